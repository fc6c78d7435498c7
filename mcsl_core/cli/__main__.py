"""``python -m mcsl_core.cli``."""

import sys

try:
    from .start import main
except KeyboardInterrupt:
    print("mcsl: stopped", file=sys.stderr)
    sys.exit(130)

sys.exit(main())
