"""From endpoint and keys to zenoh's configuration, as the nodes of a site make it."""

from __future__ import annotations

import json
import os
import re
import socket
import stat
from contextlib import suppress
from pathlib import Path
from typing import Any, Optional, Sequence, Union

import zenoh

from .errors import OptionsError, NoRouterError

#: After how long a silent link counts as dead, ms.
LEASE_MS = 2000
_ENDPOINT = re.compile(r"(tcp|quic)/[^/?#]+:[0-9]+([?#].*)?")
_SECRETS = ("key.pem", "password")


def open_session(
    endpoints: Sequence[str],
    site: str,
    keys: Union[str, os.PathLike[str], None],
    user: Optional[str],
    password: Optional[str],
    timeout: float,
) -> Any:
    """A session with one of these routers. Raises `NoRouterError` when none answers in time."""
    protection = _protection(endpoints, site, keys, user, password)
    share = timeout / len(endpoints)
    for first in range(len(endpoints)):
        # Zenoh tries the first one until the time is over.
        topology = _topology([*endpoints[first:], *endpoints[:first]], share)
        config = _config({**topology, **protection})
        with suppress(zenoh.ZError):
            return zenoh.open(config)
    raise NoRouterError(endpoints, _why_no_router(endpoints))


def _config(settings: dict[str, Any]) -> Any:
    config = zenoh.Config()
    for key, value in settings.items():
        try:
            config.insert_json5(key, json.dumps(value))
        except zenoh.ZError as cause:
            # The values of a section with a password are not repeated.
            raise OptionsError(
                f"zenoh refuses {key}: {cause}" if "auth" not in key else f"zenoh refuses {key}"
            ) from None
    return config


def _topology(endpoints: Sequence[str], timeout: float) -> dict[str, Any]:
    return {
        "mode": "client",
        "connect/endpoints": list(endpoints),
        "connect/timeout_ms": max(1, int(timeout * 1000)),
        "connect/exit_on_failure": True,
        "connect/retry": {"period_init_ms": 100, "period_max_ms": 1000, "period_increase_factor": 2},
        "listen/endpoints": [],
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "timestamping/enabled": False,
        "transport/unicast/open_timeout": 2000,
        "transport/link/tx/lease": LEASE_MS,
        "transport/link/rx/max_message_size": 4 << 20,
    }


def _protection(
    endpoints: Sequence[str],
    site: str,
    keys: Union[str, os.PathLike[str], None],
    user: Optional[str],
    password: Optional[str],
) -> dict[str, Any]:
    for endpoint in endpoints:
        if not _ENDPOINT.fullmatch(endpoint):
            raise OptionsError(
                f"{endpoint!r} is no endpoint: write tcp/<address>:<port>, or quic/<address>:<port> with keys"
            )
    is_quic = {endpoint.startswith("quic/") for endpoint in endpoints}
    if len(is_quic) != 1:
        raise OptionsError("endpoints of one protocol are needed: all tcp/ or all quic/")
    if (user is None) != (password is None):
        raise OptionsError("a user name needs a password, and a password a user name")
    if keys is not None and user is not None:
        raise OptionsError("give either a folder of keys or a user name with a password")
    if user is not None:
        return _by_password(user, password)
    if keys is None:
        if True in is_quic:
            raise OptionsError("a quic/ endpoint needs keys: keys=DIR, as `sextant keys add` makes it")
        return {}
    folder = Path(keys)
    name = _member_of(folder, site)
    if True in is_quic:
        return _by_certificate(folder)
    return _by_password(name, _read(folder / "password").strip())


def _by_password(user: str, password: Optional[str]) -> dict[str, Any]:
    # In one piece: zenoh refuses a user without a password, and a password without a user.
    return {"transport/auth/usrpwd": {"user": user, "password": password}}


def _by_certificate(folder: Path) -> dict[str, Any]:
    tls = "transport/link/tls/"
    return {
        tls + "enable_mtls": True,
        tls + "root_ca_certificate": str(folder / "authority.pem"),
        tls + "connect_certificate": str(folder / "certificate.pem"),
        tls + "connect_private_key": str(folder / "key.pem"),
        # Zenoh also trusts the web's public authorities as a router's; only the name keeps their customers out.
        tls + "verify_name_on_connect": True,
        tls + "close_link_on_expiration": True,
    }


def _member_of(folder: Path, site: str) -> str:
    """User name of a folder of keys, after checking that it belongs to this site and that its secrets are private."""
    text = _read(folder / "node.toml")
    found = {key: re.search(rf'^{key} = "([^"]*)"$', text, re.MULTILINE) for key in ("site", "common_name")}
    own, name = found["site"], found["common_name"]
    if own is None or name is None:
        raise OptionsError(
            f"{folder} is no folder of keys: node.toml names no site or no member; `sextant keys add` makes one"
        )
    if own[1] != site:
        raise OptionsError(f"the keys in {folder} are of site {own[1]}, not of {site}")
    for secret in _SECRETS:
        _check_secret(folder / secret)
    return name[1]


def role_of(keys: Union[str, os.PathLike[str]]) -> str:
    """The role of the member that a folder of keys is of."""
    found = re.search(r'^role = "([^"]*)"$', _read(Path(keys) / "node.toml"), re.MULTILINE)
    return found[1] if found else "unknown"


def _check_secret(file: Path) -> None:
    _read(file)
    if os.name == "posix" and stat.S_IMODE(file.stat().st_mode) & 0o077:
        raise OptionsError(f"{file} is secret, but others can read it: chmod 600 {file}")


def _read(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as cause:
        raise OptionsError(f"{file.parent} is no folder of keys: {file.name}: {cause}") from None


def _why_no_router(endpoints: Sequence[str]) -> Optional[str]:
    """What keeps this machine from each router, as far as a plain connection shows it."""
    causes = []
    for endpoint in endpoints:
        address = endpoint.partition("/")[2].partition("?")[0].partition("#")[0]
        host, _, port = address.rpartition(":")
        try:
            socket.create_connection((host.strip("[]"), int(port)), timeout=0.5).close()
        except (OSError, ValueError, OverflowError) as cause:
            causes.append(f"{endpoint}: {cause}")
    return "; ".join(causes) or "something listens there, but lets this program in no further"
