"""What Mitsuba 3.10 and later import once a variant is chosen: the entry point of the plug-ins.

Mitsuba imports it again after each change of the variant. That does nothing: the plug-ins register themselves then.
"""

import snowblue.mitsuba  # noqa: F401
