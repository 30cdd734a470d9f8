"""Pages of the browser that move: the crawling snake, from a file or live; their server."""
