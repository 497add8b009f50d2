"""Light: coils, modulators, interferometers and detectors of optical gyroscopes."""
