"""The protocol of pygls, changed: texts are kept once, long answers are sent as they are, no traceback leaves.

pygls keeps texts of its own and converts every answer field by field; with 20,000 lines both take longer than the
answer itself.
"""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Any

from lsprotocol import types
from pygls.exceptions import JsonRpcException, JsonRpcInternalError
from pygls.protocol import LanguageServerProtocol, lsp_method

if TYPE_CHECKING:
    from olp.servers.lsp.server import OlpLanguageServer

logger = logging.getLogger(__name__)


class Raw:
    """An answer that is JSON already."""

    def __init__(self, value: Any) -> None:
        self.value = value


class Protocol(LanguageServerProtocol):
    _server: OlpLanguageServer

    @lsp_method(types.TEXT_DOCUMENT_DID_OPEN)
    def lsp_text_document__did_open(self, params: types.DidOpenTextDocumentParams) -> None:
        self._server.texts.opened(params.text_document)

    @lsp_method(types.TEXT_DOCUMENT_DID_CHANGE)
    def lsp_text_document__did_change(self, params: types.DidChangeTextDocumentParams) -> None:
        self._server.texts.changed(params)

    @lsp_method(types.TEXT_DOCUMENT_DID_CLOSE)
    def lsp_text_document__did_close(self, params: types.DidCloseTextDocumentParams) -> None:
        self._server.texts.closed(params.text_document.uri)

    def tell(self, method: str, params: Any) -> None:
        """A notification whose parameters are JSON already."""
        self._send_data({"jsonrpc": "2.0", "method": method, "params": params})

    def plain(self, thing: Any) -> Any:
        """A type of the protocol as JSON."""
        return self._converter.unstructure(thing)

    def structure_message(self, data: dict[str, Any]) -> Any:
        try:
            return super().structure_message(data)
        except JsonRpcException as problem:
            # Nobody else would answer a question that cannot be understood.
            if "method" in data and isinstance(data.get("id"), (int, str)):
                self._send_response(data["id"], error=problem.to_response_error())
            raise

    def _send_response(
        self, msg_id: str | int, result: Any = None, error: types.ResponseError | None = None
    ) -> None:
        if error is not None:
            self._send_data({"jsonrpc": "2.0", "id": msg_id, "error": _without_traceback(error)})
        elif isinstance(result, Raw):
            self._result_types.pop(msg_id, None)
            self._send_data({"jsonrpc": "2.0", "id": msg_id, "result": result.value})
        else:
            super()._send_response(msg_id, result, error)


def _without_traceback(error: types.ResponseError) -> dict[str, Any]:
    message = error.message
    if error.code == JsonRpcInternalError.CODE:
        message = f"{message.partition(chr(10))[0]} (a mistake in olp)"
    return {"code": int(error.code), "message": message}
