"""A calibration session shown: report, table, pictures and page."""
