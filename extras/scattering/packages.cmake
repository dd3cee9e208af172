# SPDX-License-Identifier: Apache-2.0
if(HAPTOGRAM_OPENBLAS)
  set(BLA_VENDOR OpenBLAS)
  haptogram_need(LAPACK libopenblas-dev)
endif()
