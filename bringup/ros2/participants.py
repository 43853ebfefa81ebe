"""How many DDS participants this machine has in a domain, told by the ports that they hold."""

from __future__ import annotations

from pathlib import Path

# DDSI-RTPS 2.5, section 9.6.2: port = 7400 + 250 domain + 10 + 2 participant (discovery, unicast)
_BASE, _DOMAIN_GAIN, _OFFSET, _PARTICIPANT_GAIN = 7400, 250, 10, 2
_MOST = 120  # participants a domain; the next domain's ports follow
_TABLE = Path("/proc/net/udp")


def on_this_machine(domain: int) -> int | None:
    """Return the number of participants of a domain, this process's too; None if unknown."""
    if not _TABLE.is_file():
        return None
    return count(domain, _TABLE.read_text(encoding="ascii"))


def count(domain: int, table: str) -> int:
    """Return the number of participants whose ports stand in a table of UDP sockets.

    Args:
        domain: The domain.
        table: As /proc/net/udp gives it.
    """
    first = _BASE + _DOMAIN_GAIN * domain + _OFFSET
    expected = range(first, first + _MOST * _PARTICIPANT_GAIN, _PARTICIPANT_GAIN)
    addresses = (line.split()[1] for line in table.splitlines()[1:])
    return len({int(address.split(":")[1], 16) for address in addresses} & set(expected))
