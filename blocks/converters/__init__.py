"""From numbers to codes and back."""
