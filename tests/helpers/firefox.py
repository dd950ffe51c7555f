"""Firefox without a driver, by the standard protocol WebDriver BiDi."""

import json
import shutil
import subprocess
from base64 import b64decode
from contextlib import contextmanager
from itertools import count

from websocket import create_connection  # comes with selenium

FIREFOX = next(filter(None, map(shutil.which, ("firefox", "firefox-esr"))), None)


class Firefox:
    """One tab of a browser, which saves downloads in `folder`."""

    def __init__(self, address, folder):
        self.folder = folder
        # Without an origin, which Firefox refuses.
        self._socket = create_connection(f"{address}/session", timeout=60, suppress_origin=True)
        self._numbers = count()
        self.call("session.new", capabilities={})
        self._tab = self.call("browsingContext.getTree")["contexts"][0]["context"]

    def call(self, method, **parameters):
        """Call a method of the protocol, and return its result."""
        number = next(self._numbers)
        self._socket.send(json.dumps({"id": number, "method": method, "params": parameters}))
        while (answer := json.loads(self._socket.recv())).get("id") != number:
            pass  # an event
        if answer["type"] == "error":
            raise RuntimeError(f"{method}: {answer['error']}: {answer['message']}")
        return answer["result"]

    def resize(self, width, height):
        """Change the size of the window."""
        self.call("browsingContext.setViewport", context=self._tab, viewport={"width": width, "height": height})

    def open(self, address, width, height):
        """Open a page in a window of some size."""
        self.resize(width, height)
        self.call("browsingContext.navigate", context=self._tab, url=address, wait="complete")

    def run(self, script):
        """Return what a function without arguments returns in the page, through JSON; it may be asynchronous."""
        answer = self.call(
            "script.evaluate",
            expression=f"(async () => JSON.stringify(await ({script})() ?? null))()",
            target={"context": self._tab},
            awaitPromise=True,
        )
        if answer["type"] == "exception":
            raise RuntimeError(answer["exceptionDetails"]["text"])
        return json.loads(answer["result"]["value"])

    def press(self, *keys):
        """Press and release keys. In a window without a screen, which has no focus, no key presses a button."""
        actions = [{"type": kind, "value": key} for key in keys for kind in ("keyDown", "keyUp")]
        source = {"type": "key", "id": "keyboard", "actions": actions}
        self.call("input.performActions", context=self._tab, actions=[source])

    def picture(self):
        """Return a picture of the page as PNG."""
        return b64decode(self.call("browsingContext.captureScreenshot", context=self._tab)["data"])

    def close(self):
        """End the session."""
        self.call("session.end")
        self._socket.close()


@contextmanager
def firefox(folder):
    """Start Firefox with an empty profile in a folder, where it also saves downloads, and end it."""
    settings = {"browser.download.folderList": 2, "browser.download.dir": str(folder)}
    lines = [f"user_pref({json.dumps(name)}, {json.dumps(value)});\n" for name, value in settings.items()]
    (folder / "user.js").write_text("".join(lines), encoding="utf-8")
    command = [FIREFOX, "--headless", "--no-remote", "--profile", str(folder), "--remote-debugging-port", "0"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, encoding="utf-8") as process:
        try:
            said = iter(process.stderr.readline, "")
            address = next(line.split()[-1] for line in said if "WebDriver BiDi listening on" in line)
            browser = Firefox(address, folder)
            yield browser
            browser.close()
        finally:
            process.terminate()
