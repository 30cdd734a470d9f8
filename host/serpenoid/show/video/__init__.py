"""Pictures round a film: the sheet of tags to print, and what a film showed."""
