# SPDX-License-Identifier: Apache-2.0
import pytest
from bindings import Haptogram


@pytest.fixture(scope="session")
def c():
    return Haptogram()
