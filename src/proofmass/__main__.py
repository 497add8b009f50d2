"""`python -m proofmass` is the command `proofmass`."""

import sys

from proofmass.runner.command_line import main

sys.exit(main())
