"""A headless Chromium, driven over its DevTools protocol with nothing but Python's standard library."""

import base64
import json
import os
import shutil
import socket
import struct
import subprocess
import tempfile
import time
import urllib.request


class Browser:
    """One page of a browser; `errors` holds what its console and its scripts complained of since `open`."""

    def __init__(self, program):
        self.profile = tempfile.mkdtemp(prefix="credence-browser-")
        self.process = subprocess.Popen(
            [program, "--headless=new", "--no-sandbox", "--disable-gpu", "--remote-debugging-port=0",
             "--remote-allow-origins=*", "--user-data-dir=" + self.profile, "about:blank"],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        port = self._port()
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/json") as pages:
            page = next(p for p in json.load(pages) if p["type"] == "page")
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=120)
        key = base64.b64encode(os.urandom(16)).decode()
        path = page["webSocketDebuggerUrl"].split(f":{port}", 1)[1]
        self.socket.sendall((f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\n"
                             f"Connection: Upgrade\r\nSec-WebSocket-Key: {key}\r\n"
                             "Sec-WebSocket-Version: 13\r\n\r\n").encode())
        self.stream = self.socket.makefile("rb")
        while self.stream.readline() != b"\r\n":
            pass
        self.number, self.events = 0, []
        for domain in ("Page", "Runtime", "Log"):
            self.call(domain + ".enable")

    def _port(self):
        told = os.path.join(self.profile, "DevToolsActivePort")
        for _ in range(1200):
            if os.path.exists(told) and os.path.getsize(told) > 0:
                with open(told) as file:
                    return int(file.readline())
            time.sleep(0.05)
        raise RuntimeError("the browser did not start within a minute")

    def close(self):
        self.process.terminate()
        self.process.wait()
        shutil.rmtree(self.profile, ignore_errors=True)

    def call(self, method, **parameters):
        self.number += 1
        self._send(json.dumps({"id": self.number, "method": method, "params": parameters}).encode())
        while True:
            message = self._receive()
            if message.get("id") == self.number:
                if "error" in message:
                    raise RuntimeError(f"{method}: {message['error']}")
                return message["result"]
            self.events.append(message)

    def _send(self, data):
        mask, size = os.urandom(4), len(data)
        head = (bytes([0x81, 0x80 | size]) if size < 126 else
                b"\x81\xfe" + struct.pack(">H", size) if size < 65536 else b"\x81\xff" + struct.pack(">Q", size))
        self.socket.sendall(head + mask + bytes(b ^ mask[i % 4] for i, b in enumerate(data)))

    def _receive(self):
        data, last = b"", False
        while not last:
            first, size = self.stream.read(2)
            if size == 126:
                size, = struct.unpack(">H", self.stream.read(2))
            elif size == 127:
                size, = struct.unpack(">Q", self.stream.read(8))
            data, last = data + self.stream.read(size), bool(first & 0x80)
        return json.loads(data)

    def view(self, width, height=900, dark=False):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1,
                  mobile=width < 600)
        self.call("Emulation.setEmulatedMedia",
                  features=[{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])

    def open(self, path):
        self._go("about:blank")
        self.events.clear()
        self._go("file://" + str(path))

    def _go(self, address):
        self.call("Page.navigate", url=address)
        ready = f"location.href === {json.dumps(address)} && document.readyState === 'complete'"
        for _ in range(1200):
            if self.run(ready):
                return
            time.sleep(0.02)
        raise RuntimeError(f"{address} was not loaded")

    def run(self, script):
        result = self.call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in result:
            raise RuntimeError(result["exceptionDetails"])
        return result["result"].get("value")

    def mouse(self, kind, x, y, **more):
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def key(self, key):
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key)

    def errors(self):
        def is_error(event):
            parameters = event.get("params", {})
            return (event["method"] == "Runtime.exceptionThrown"
                    or event["method"] == "Log.entryAdded" and parameters["entry"]["level"] == "error"
                    or event["method"] == "Runtime.consoleAPICalled" and parameters["type"] == "error")

        self.run("1")  # what was said before comes before its answer
        return [event for event in self.events if "method" in event and is_error(event)]

    def picture(self, path):
        with open(path, "wb") as file:
            file.write(base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"]))
