"""``python -m mcsl_core.cli``."""

import sys

try:
    from .start import main
except KeyboardInterrupt:
    sys.exit(130)

sys.exit(main())
