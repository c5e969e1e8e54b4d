#!/usr/bin/env python3
"""Many homes behind HAProxy, measured: answers' times, memory, and fail-over when a process is killed.

    bench/many_homes.py --program build/release/bin/roomwise --home some.home --work /tmp/many --homes 40 --devices 60

Makes a folder with copies of HOME, starts --workers processes that serve it and HAProxy by packaging/homes/haproxy.cfg
(with other ports and paths), lets devices ask, kills a process with devices, and says what became of them. Everything
runs on this computer; needs Debian's haproxy. With --accounts postgresql://... staff's accounts are kept there.
Exits with 1 where a device heard of another home, was let into one, or had no answer within --most seconds of the kill.
"""

import argparse
import base64
import json
import os
import re
import shutil
import signal
import socket
import ssl
import statistics
import struct
import subprocess
import sys
import threading
import time
from pathlib import Path
from urllib.parse import quote

ROOT = Path(__file__).resolve().parent.parent
PASSWORD = "a password of a measurement"
WAITS_S = [0.25, 0.5, 1, 2, 4, 8]  # as the phone's page waits before it connects again


class Lost(Exception):
    """The connection is gone."""


class Client:
    """One TLS connection to the proxy."""

    def __init__(self, port, authority):
        context = ssl.create_default_context(cafile=str(authority))
        raw = socket.create_connection(("127.0.0.1", port), timeout=60)
        raw.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.stream = context.wrap_socket(raw, server_hostname="localhost")
        self.read = self.stream.makefile("rb")

    def request(self, method, path, headers=None, body=None):
        data = b"" if body is None else json.dumps(body).encode()
        lines = [f"{method} {path} HTTP/1.1", "Host: localhost"]
        lines += [f"{name}: {value}" for name, value in (headers or {}).items()]
        if body is not None or method != "GET":
            lines.append(f"Content-Length: {len(data)}")
        self.stream.sendall("\r\n".join(lines).encode() + b"\r\n\r\n" + data)
        return self._answer()

    def _answer(self):
        first = self.read.readline()
        if not first:
            raise Lost("closed")
        status = int(first.split()[1])
        headers = {}
        while (line := self.read.readline().strip()):
            name, _, value = line.decode().partition(":")
            headers[name.lower()] = value.strip()
        body = self.read.read(int(headers.get("content-length", 0))) if status != 101 else b""
        return status, headers, body

    def open_socket(self, path, token):
        key = base64.b64encode(os.urandom(16)).decode()
        status, _, body = self.request("GET", path, {
            "Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13", "Sec-WebSocket-Key": key,
            "Sec-WebSocket-Protocol": "roomwise.1", "Authorization": f"Bearer {token}"})
        if status != 101:
            raise Lost(f"{status} {body[:200]!r}")

    def _send(self, opcode, payload):
        mask = os.urandom(4)
        size = len(payload)
        head = struct.pack("!BB", 0x80 | opcode, 0x80 | size) if size < 126 else struct.pack("!BBH", 0x80 | opcode, 0x80 | 126, size)
        self.stream.sendall(head + mask + bytes(b ^ mask[i % 4] for i, b in enumerate(payload)))

    def send(self, message):
        self._send(1, json.dumps(message).encode())

    def receive(self):
        while True:
            head = self.read.read(2)
            if len(head) < 2:
                raise Lost("closed")
            size = head[1] & 0x7F
            if size == 126:
                size = struct.unpack("!H", self.read.read(2))[0]
            elif size == 127:
                size = struct.unpack("!Q", self.read.read(8))[0]
            payload = self.read.read(size)
            opcode = head[0] & 0x0F
            if opcode == 9:
                self._send(10, payload)
            elif opcode == 8:
                raise Lost("closed by the computer")
            elif opcode == 1:
                return json.loads(payload)

    def close(self):
        self.stream.close()


class Device(threading.Thread):
    """Asks its home a question again and again, and connects anew by itself."""

    def __init__(self, bench, home, token, pause_s):
        super().__init__(daemon=True)
        self.bench, self.home, self.token, self.pause_s = bench, home, token, pause_s
        self.answers = []  # (when it was answered, how long that took)
        self.foreign = []
        self.connections = 0
        self.failures = []
        self.ending = False

    def run(self):
        tries = 0
        while not self.ending:
            try:
                client = Client(self.bench.port, self.bench.authority)
                client.open_socket(f"/homes/{self.home}/api/socket", self.token)
                client.send({"type": "hello", "version": 1, "name": "device", "kind": "wearable", "camera": None,
                             "language": "en", "distances": "metres", "step_m": 0.7, "callouts": False})
                self.connections += 1
                number = 0
                while not self.ending:
                    number += 1
                    began = time.monotonic()
                    client.send({"type": "ask", "id": number, "t": began * 1000, "question": "what_is_in",
                                 "room": f"room of {self.home}"})
                    while True:
                        message = client.receive()
                        tries = 0
                        self.check(message)
                        if message["type"] == "error":
                            self.failures.append(message["text"])
                        if message.get("answer_to") == number:
                            break
                    if self.home not in message.get("text", ""):
                        self.failures.append(f"an answer without the home's room: {message.get('text')}")
                    now = time.monotonic()
                    self.answers.append((now, now - began))
                    time.sleep(self.pause_s)
            except (Lost, OSError, ValueError) as lost:
                if not self.ending:
                    self.failures.append(str(lost))
                    time.sleep(WAITS_S[min(tries, len(WAITS_S) - 1)])
                    tries += 1

    def check(self, message):
        """A room of each home is called after it, and so is the home."""
        others = set(re.findall(r"flat-[0-9]+", json.dumps(message))) - {self.home}
        if others:
            self.foreign.append(message)


class Bench:
    def __init__(self, options):
        self.options = options
        self.work = Path(options.work)
        self.folder = self.work / "homes"
        self.authority = self.folder / "house.access" / "authority.pem"
        self.workers = []
        self.proxy = None
        self.port = 0

    def roomwise(self, *arguments):
        done = subprocess.run([self.options.program, *map(str, arguments)], capture_output=True, text=True)
        if done.returncode != 0:
            raise SystemExit(f"roomwise {' '.join(map(str, arguments))}: {done.stderr}")
        return done.stdout

    def make_homes(self):
        shutil.rmtree(self.work, ignore_errors=True)
        self.folder.mkdir(parents=True)
        self.names = [f"flat-{i + 1}" for i in range(self.options.homes)]
        for name in self.names:
            shutil.copyfile(self.options.home, self.folder / f"{name}.home")

    def accounts(self):
        more = ["--accounts", self.options.accounts] if self.options.accounts else []
        secret = self.work / "password"
        secret.write_text(PASSWORD)
        self.roomwise("accounts", "add", self.folder, "anna", "--password-file", secret, *more)
        for name in self.names:
            self.roomwise("accounts", "role", self.folder, "anna", name, "helper", *more)

    def start_worker(self, number):
        more = ["--accounts", self.options.accounts] if self.options.accounts else []
        log = open(self.work / f"worker{number}.log", "ab")
        process = subprocess.Popen(
            [self.options.program, "serve", str(self.folder), "--port", "0", "--proxy", "127.0.0.1", "--open-homes",
             str(self.options.open_homes), "--threads", str(self.options.threads), "--name", "localhost", *more],
            stdout=subprocess.PIPE, stderr=log, stdin=subprocess.DEVNULL, text=True)
        port = 0
        for line in process.stdout:
            if (found := re.search(r"at port (\d+)", line)):
                port = int(found[1])
            if "Ctrl-C" in line:
                break
        if port == 0:
            raise SystemExit(f"worker {number} did not start: see {log.name}")
        self.workers.append((process, port))

    def start_proxy(self):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        text = (ROOT / "packaging/homes/haproxy.cfg").read_text()
        text = text.replace("/var/lib/roomwise/homes", str(self.folder)).replace("bind :8443", f"bind 127.0.0.1:{self.port}")
        for number, (_, port) in enumerate(self.workers):
            text = text.replace(f"127.0.0.1:{9001 + number}", f"127.0.0.1:{port}")
        for number in range(len(self.workers), 3):
            text = re.sub(rf"  server worker{number + 1} .*\n", "", text)
        file = self.work / "haproxy.cfg"
        file.write_text(text)
        self.proxy = subprocess.Popen(["haproxy", "-W", "-db", "-f", str(file)], stdout=open(self.work / "haproxy.log", "wb"),
                                      stderr=subprocess.STDOUT)
        end = time.monotonic() + 20
        while time.monotonic() < end:
            try:
                if Client(self.port, self.authority).request("GET", "/health")[0] == 200:
                    return
            except (OSError, Lost):
                pass
            time.sleep(0.1)
        raise SystemExit("HAProxy does not answer: see haproxy.log")

    def pair(self):
        """A device for each, handed round the homes; by codes that a member of staff makes."""
        client = Client(self.port, self.authority)
        status, headers, body = client.request("POST", "/api/staff/sign-in", body={"name": "anna", "password": PASSWORD})
        if status != 200:
            raise SystemExit(f"signing in: {status} {body}")
        cookie = {"Cookie": headers["set-cookie"].split(";")[0]}
        self.first_s = []
        self.opened_s = []
        # A room of each home is called after it, so that an answer of another home shows.
        for home in self.names:
            began = time.monotonic()
            status, _, body = client.request("GET", f"/homes/{home}/api/home", cookie)
            self.opened_s.append(time.monotonic() - began)
            if status != 200 or not json.loads(body)["rooms"]:
                raise SystemExit(f"{home}: {status} {body[:200]}; --home must have a room")
            room = quote(json.loads(body)["rooms"][0]["name"], safe="")
            status, _, body = client.request("PUT", f"/homes/{home}/api/rooms/{room}", cookie, {"name": f"room of {home}"})
            if status != 200:
                raise SystemExit(f"renaming {room} in {home}: {status} {body}")
        devices = []
        for i in range(self.options.devices):
            home = self.names[i % len(self.names)]
            began = time.monotonic()
            status, _, body = client.request("POST", f"/homes/{home}/api/codes", cookie, {"role": "device"})
            if status != 200:
                raise SystemExit(f"a code for {home}: {status} {body}")
            secret = json.loads(body)["address"].split("#")[1]
            status, _, body = client.request("POST", f"/homes/{home}/api/pair", {}, {"secret": secret, "name": f"device {i}"})
            if status != 200:
                raise SystemExit(f"pairing in {home}: {status} {body}")
            token = json.loads(body)["token"]
            self.first_s.append(time.monotonic() - began)
            devices.append(Device(self, home, token, self.options.pause))
        return devices

    def crossed(self, devices):
        """Every device against a home that is not its own, by each of these requests."""
        answers = {}
        client = Client(self.port, self.authority)
        for i, device in enumerate(devices):
            for step in (1, 7, len(self.names) // 2):
                other = self.names[(self.names.index(device.home) + step) % len(self.names)]
                if other == device.home:
                    continue
                for method, path in (("GET", "/api/home"), ("GET", "/api/me"), ("GET", "/api/devices"), ("POST", "/api/leave"),
                                     ("GET", "/api/socket"), ("GET", "/metrics")):
                    # All come from one address, of which strangers may ask 40 times a second.
                    status = 429
                    while status == 429:
                        status, headers, _ = client.request(
                            method, f"/homes/{other}{path}", {"Authorization": f"Bearer {device.token}"},
                            {} if method == "POST" else None)
                        if status == 429:
                            time.sleep(0.5)
                    answers[status] = answers.get(status, 0) + 1
        return answers

    def owner(self, home):
        """The process that has the home: the one that does not say 503 when it is asked itself."""
        for index, (process, port) in enumerate(self.workers):
            if process.poll() is None and Client(port, self.authority).request("GET", f"/homes/{home}/api/me")[0] == 401:
                return index
        return None

    def memory_mb(self):
        def resident(pid):
            for line in Path(f"/proc/{pid}/status").read_text().splitlines():
                if line.startswith("VmRSS"):
                    return int(line.split()[1]) / 1024
            return 0.0
        return [round(resident(process.pid), 1) for process, _ in self.workers if process.poll() is None]

    def end(self):
        for process, _ in self.workers:
            if process.poll() is None:
                process.send_signal(signal.SIGTERM)
        if self.proxy:
            self.proxy.terminate()
        for process, _ in self.workers:
            try:
                process.wait(60)
            except subprocess.TimeoutExpired:
                process.kill()


def quantiles_ms(values):
    values = sorted(values)
    if not values:
        return None
    pick = lambda share: round(values[min(len(values) - 1, int(share * len(values)))] * 1000, 1)
    return {"count": len(values), "median": pick(0.5), "95 %": pick(0.95), "99 %": pick(0.99), "longest": pick(1)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/roomwise"))
    parser.add_argument("--home", required=True, help="home file that is copied")
    parser.add_argument("--work", required=True, help="folder for everything; emptied first")
    parser.add_argument("--homes", type=int, default=40)
    parser.add_argument("--workers", type=int, default=3, choices=(1, 2, 3))
    parser.add_argument("--devices", type=int, default=60)
    parser.add_argument("--open-homes", type=int, default=40, help="of each process")
    parser.add_argument("--threads", type=int, default=1, help="of each process")
    parser.add_argument("--pause", type=float, default=1.0, help="seconds between a device's questions")
    parser.add_argument("--seconds", type=float, default=30, help="of asking before the kill, and after it")
    parser.add_argument("--most", type=float, default=5, help="seconds within which all are to be answered again")
    parser.add_argument("--accounts", default="")
    options = parser.parse_args()
    bench = Bench(options)
    bench.make_homes()
    result = {"homes": options.homes, "workers": options.workers, "devices": options.devices,
              "processors": os.cpu_count(), "load": os.getloadavg()[0]}
    try:
        for number in range(options.workers):
            bench.start_worker(number + 1)
        result["memory of empty processes (MB)"] = bench.memory_mb()
        bench.accounts()
        bench.start_proxy()
        devices = bench.pair()
        result["opening a home, its first answer (ms)"] = quantiles_ms(bench.opened_s)
        result["code and pairing (ms)"] = quantiles_ms(bench.first_s)
        result["crossed requests, by status"] = bench.crossed(devices)
        began = time.monotonic()
        for device in devices:
            device.start()
        while not all(device.answers for device in devices) and time.monotonic() - began < 300:
            time.sleep(0.05)
        result["until every device had an answer (s)"] = round(time.monotonic() - began, 1)
        steady = time.monotonic()
        time.sleep(options.seconds)
        result["answers (ms)"] = quantiles_ms([took for device in devices for when, took in device.answers if when > steady])
        result["memory (MB)"] = bench.memory_mb()
        owners = {home: bench.owner(home) for home in bench.names}
        result["homes of each process"] = [sum(owner == i for owner in owners.values()) for i in range(options.workers)]
        if options.workers > 1:
            victim = max(range(options.workers), key=lambda i: sum(owners[device.home] == i for device in devices))
            hit = [device for device in devices if owners[device.home] == victim]
            spared = [device for device in devices if owners[device.home] != victim]
            killed = time.monotonic()
            bench.workers[victim][0].kill()
            time.sleep(max(options.seconds, options.most * 2))
            # The first question that was both asked and answered after the kill.
            again = [min((when for when, took in device.answers if when - took > killed), default=None) for device in hit]
            late = [when - killed if when else None for when in again]
            result["killed"] = {
                "its devices": len(hit), "its homes": sum(owner == victim for owner in owners.values()),
                "answered again": sum(one is not None for one in late),
                "until each was answered again (ms)": quantiles_ms([one for one in late if one is not None]),
                "others' answers meanwhile (ms)": quantiles_ms(
                    [took for device in spared for when, took in device.answers if killed < when < killed + 5]),
                "others' connections lost": sum(device.connections - 1 for device in spared)}
            result["memory afterwards (MB)"] = bench.memory_mb()
            is_late = any(one is None or one > options.most for one in late)
        else:
            is_late = False
        result["answers of another home"] = sum(len(device.foreign) for device in devices)
        reasons = {}
        for device in devices:
            for reason in device.failures:
                reasons[reason[:80]] = reasons.get(reason[:80], 0) + 1
        result["what connections were lost by"] = reasons
        for device in devices:
            device.ending = True
    finally:
        bench.end()
    print(json.dumps(result, indent=2, ensure_ascii=False))
    return 1 if is_late or result["answers of another home"] or set(result["crossed requests, by status"]) != {401} else 0


if __name__ == "__main__":
    sys.exit(main())
