"""The lock under which LLVM works: one compilation at a time, none across a fork, none while the
process is taken down.

It stands alone, since those who wait for it must not import LLVM.
"""

import os
import threading

AT_WORK = threading.Lock()  # held while LLVM compiles or links

if hasattr(os, "register_at_fork"):  # no child finds it held by a thread that it does not have
    os.register_at_fork(before=AT_WORK.acquire, after_in_parent=AT_WORK.release, after_in_child=AT_WORK.release)
