"""Pages of the browser that move: the crawling snake, in a file."""
