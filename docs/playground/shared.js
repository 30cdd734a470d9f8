// What page and worker both need: limits of frequency, and the cells of the map.
"use strict";
const RAD = Math.PI / 180, CELLS = 40, CELL_ALPHA = 3, CELL_BETA = 4.5, MOST_HZ = 3;
const highestHz = (s) => TABLES.servos[s.servo].limitRadS / (2 * Math.PI * s.alpha * RAD);
// The end of the curve: so far beyond that frequency that hatching and setting are in view.
const topHz = (s) => Math.min(MOST_HZ, Math.max(1.4 * highestHz(s), 1.1 * s.hz));
