"""A calibration session shown: report, table, sheet, pictures in terminal, window and page."""
