"""Whose pages in a browser may connect to a server on this machine, by their `Origin`."""

from __future__ import annotations

import re

OF_THIS_MACHINE = re.compile(r"https?://(localhost|127\.\d+\.\d+\.\d+|\[::1\])(:\d+)?")
"""Pages that this machine serves."""
OF_FOXGLOVE = re.compile(r"https://(app|studio)\.foxglove\.dev|(?!https?:)[a-z][\w+.-]*:.*")
"""Foxglove's pages, and applications' own, as `file://`: no site can have these."""
