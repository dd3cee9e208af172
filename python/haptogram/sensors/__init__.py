# SPDX-License-Identifier: Apache-2.0
"""Depth cameras and hand trackers, for `haptogram live`: what they see goes over a pipe."""
