# SPDX-License-Identifier: Apache-2.0
import sys

from haptogram_sweep.cli import main

if __name__ == "__main__":  # workers are started by importing this file again
    sys.exit(main())
