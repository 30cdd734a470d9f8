"""The commands that deal with a board: ports, doctor, flash, drive, trim, monitor."""

from .doctor import doctor
from .drive import drive
from .flash import flash
from .monitor import monitor
from .ports import ports
from .trim import trim

COMMANDS = (ports, doctor, flash, drive, trim, monitor)
