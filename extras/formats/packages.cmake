# SPDX-License-Identifier: Apache-2.0
haptogram_need(pugixml libpugixml-dev)
