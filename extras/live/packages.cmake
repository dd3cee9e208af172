# SPDX-License-Identifier: Apache-2.0
haptogram_need(PNG libpng-dev)
haptogram_need_module(BULLET libbullet-dev bullet)
