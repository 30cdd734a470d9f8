"""What a person does with a board: doctor, upload, monitor, trim, drive."""
