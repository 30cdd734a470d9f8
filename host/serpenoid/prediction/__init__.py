"""From friction to speed: a band, a verdict on what crawled, and what to measure next."""
