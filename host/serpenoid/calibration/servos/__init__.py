"""What gait runs and films of a session say about the servos."""
