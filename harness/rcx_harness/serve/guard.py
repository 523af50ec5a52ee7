"""The protection of all pages of this package: loopback interface, random token, same origin."""

from __future__ import annotations

import hmac
import json
import logging
import secrets
from collections.abc import Awaitable, Callable, Mapping
from importlib.resources import files
from typing import Any

from aiohttp import web
from aiohttp.http_exceptions import HttpProcessingError

from structured_text.errors import InputError

__all__ = ["WEB_HOST", "TokenServer", "add_files", "guarded", "read_message"]

WEB_HOST = "127.0.0.1"
"""The address of all pages; no other computer can reach it."""

_TOKEN_BYTES = 16
_OWN_NAMES = ("127.0.0.1", "localhost")
_CHARSETS = ("utf-8", "utf8", "us-ascii")
_LARGEST_REQUEST = 4096
_HEADERS = {
    "Cache-Control": "no-store",
    # The charts contain their style sheet; nothing is loaded from other hosts.
    "Content-Security-Policy": (
        "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; "
        "frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
    ),
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
}
_TOKEN: web.AppKey[str] = web.AppKey("token", str)
_COMMAND: web.AppKey[str] = web.AppKey("command", str)
_FILES: web.AppKey[Mapping[str, tuple[str, str, str]]] = web.AppKey("files", Mapping)
#: Errors that the sender of a request has caused. They are answered, but not logged, because the
#: log is for errors of this program.
_SENDERS_FAULTS = (HttpProcessingError, web.RequestPayloadError, ConnectionError)
_LOG = logging.getLogger(__name__)
_LOG.addFilter(lambda record: not isinstance((record.exc_info or (0, 0))[1], _SENDERS_FAULTS))
_Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


def guarded(token: str, command: str) -> web.Application:
    """Create an application with the token in its paths; `command` is named in messages."""
    app = web.Application(middlewares=[_guard], client_max_size=_LARGEST_REQUEST)
    app[_TOKEN], app[_COMMAND] = token, command
    app.router.add_get(f"/{token}", _to_page)
    return app


def add_files(app: web.Application, served: Mapping[str, tuple[str, str, str]]) -> None:
    """Serve static files.

    `served` gives for each path the package, the file in the package's folder `page`, and the type
    of the file.
    """
    app[_FILES] = served
    for path in served:
        app.router.add_get(f"/{app[_TOKEN]}{path}", _file)


class TokenServer:
    """A server for a page on the loopback interface.

    Args:
        option: The option of the command line for the port, for messages.
        token: First part of the paths; default: a random token.
    """

    def __init__(
        self,
        application: Callable[[str], web.Application],
        port: int,
        option: str,
        token: str = "",
    ) -> None:
        self._token = token or secrets.token_urlsafe(_TOKEN_BYTES)
        self._option = option
        self._runner = web.AppRunner(
            application(self._token), access_log=None, logger=_LOG, auto_decompress=False
        )
        self.port = port

    @property
    def address(self) -> str:
        """Return the address of the page, with its token."""
        return f"http://{WEB_HOST}:{self.port}/{self._token}/"

    async def start(self) -> None:
        """Start to listen for connections."""
        await self._runner.setup()
        try:
            await web.TCPSite(self._runner, WEB_HOST, self.port).start()
        except (OSError, OverflowError) as error:
            await self.close()
            reason = getattr(error, "strerror", None) or str(error)
            raise InputError(
                f"the web page cannot be served on {WEB_HOST}:{self.port}: {reason}",
                hint=f"choose a free port with {self._option}",
            ) from None
        self.port = self._runner.addresses[0][1]

    async def close(self) -> None:
        """Stop the server."""
        await self._runner.cleanup()


@web.middleware
async def _guard(request: web.Request, handler: _Handler) -> web.StreamResponse:
    """Refuse requests without the token, from another host or origin; add the security headers.

    The token is secret, so no other user of this computer can open the page. The check of the host
    name prevents DNS rebinding: a foreign site could resolve its own name to this computer. The
    check of the origin stops a foreign page in the same browser from sending requests.
    """
    host, _, _port = request.host.rpartition(":")
    if (host or request.host) not in _OWN_NAMES:
        # A foreign site can let its own name resolve to this address (DNS rebinding).
        response: web.StreamResponse = _error(403, "this page is for this machine only")
    elif not _has_token(request):
        response = _error(403, _without_token(request))
    elif request.headers.get("Origin", _own_origin(request)) != _own_origin(request):
        response = _error(
            403, "only the page itself may do this, and this request has another origin"
        )
    else:
        try:
            response = await handler(request)
        except InputError as error:
            response = _error(400, str(error))
        except web.RequestPayloadError:
            response = _error(400, "the request is incomplete, or its headers do not describe it")
        except web.HTTPRequestEntityTooLarge:
            response = _error(400, f"the request is longer than {_LARGEST_REQUEST} bytes")
        except web.HTTPException as error:
            response = _error(error.status, error.reason)
    response.headers.update(_HEADERS)
    return response


def _without_token(request: web.Request) -> str:
    command = request.app[_COMMAND]
    return f"the address lacks its token: open the one that {command} printed at its start"


def _has_token(request: web.Request) -> bool:
    given = request.path.split("/")[1] if request.path.startswith("/") else ""
    return hmac.compare_digest(given.encode("utf-8", "replace"), request.app[_TOKEN].encode())


def _own_origin(request: web.Request) -> str:
    return f"http://{request.host}"


def _error(status: int, text: str) -> web.Response:
    return web.json_response({"error": text}, status=status)


async def _to_page(request: web.Request) -> web.Response:
    """Redirect to the address with a slash at its end; all paths of the page are relative to it."""
    return web.Response(status=308, headers={"Location": f"/{request.app[_TOKEN]}/"})


async def _file(request: web.Request) -> web.Response:
    package, name, kind = request.app[_FILES]["/" + request.path.split("/", 2)[2]]
    body = files(package).joinpath("page").joinpath(name).read_bytes()
    return web.Response(body=body, content_type=kind, charset="utf-8")


async def read_message(
    request: web.Request, example: str, what: str, **needed: type[Any]
) -> dict[str, Any]:
    """Read the JSON object of a request.

    Raise InputError if an entry in `needed` is missing or has another type.
    """
    charset = request.charset or "utf-8"
    if charset.lower() not in _CHARSETS:
        raise InputError(f"the charset {charset[:20]!r} is not accepted", hint="send UTF-8")
    if request.headers.get("Content-Encoding", "identity") != "identity":
        raise InputError("a compressed request is not accepted", hint="send it uncompressed")
    try:
        message: Any = json.loads(await request.read())
    except (ValueError, RecursionError):
        message = None
    fits = isinstance(message, dict) and all(
        type(message.get(name)) is kind for name, kind in needed.items()
    )
    if not fits:
        raise InputError(f"{what} is expected: {example}")
    found: dict[str, Any] = message
    return found
