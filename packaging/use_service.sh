#!/bin/sh
# Run by root inside a booted Debian that has the packages: the service at its work, under its hardening. Says what it
# did; its last line is "all right" where it was.
set -eu
unit=/lib/systemd/system/roomwise.service
log() { journalctl --no-pager --output cat --unit "$1"; }

[ "$(systemctl is-enabled roomwise || true)" = disabled ] || { echo "the service is enabled by itself"; exit 1; }
[ "$(systemctl is-active roomwise || true)" = inactive ] || { echo "the service runs by itself"; exit 1; }

# All that the unit forbids, while a recording is mapped with the network that comes with Roomwise.
map="roomwise map /packages/tum_fr1_desk_9frames --camera fr1 --home /var/lib/roomwise/home.home"
sed -e "s|^ExecStart=.*|ExecStart=/usr/bin/$map|" -e 's/^Restart=.*/Type=oneshot/' $unit \
  >/etc/systemd/system/roomwise-map.service
mkdir /etc/systemd/system/roomwise.service.d
printf '[Service]\nEnvironment="ROOMWISE_SERVE=%s"\n' \
  "--address 0.0.0.0 --pair device --speak wav:/var/lib/roomwise/code.wav" \
  >/etc/systemd/system/roomwise.service.d/options.conf
systemctl daemon-reload
systemctl start roomwise-map || { log roomwise-map; exit 1; }
log roomwise-map | grep '^networks  *roomwise-compact'

# The home served, the code spoken by espeak-ng.
systemctl start roomwise
python3 - <<'X' || { log roomwise; exit 1; }
import ssl, time, urllib.request
anyone = ssl._create_unverified_context()
for wait_s in [0.2] * 150:
    try:
        print(urllib.request.urlopen("https://127.0.0.1:8443/health", context=anyone).read().decode())
        break
    except OSError:
        time.sleep(wait_s)
else:
    raise SystemExit("the service does not answer")
X
spoken=/var/lib/roomwise/code.wav tries=0
until [ "$(stat -c %s $spoken 2>/dev/null || echo 0)" -gt 10000 ]; do
  tries=$((tries + 1))
  [ $tries -lt 150 ] || { log roomwise; echo "the code is not spoken"; exit 1; }
  sleep 0.2
done
systemctl stop roomwise
[ "$(systemctl show --property Result --value roomwise)" = success ] || { log roomwise; exit 1; }
[ "$(stat -c %a:%U /var/lib/roomwise /var/lib/roomwise/home.home | tr '\n' ' ')" = "700:roomwise 600:roomwise " ] ||
  { echo "others can read the home"; exit 1; }
echo "all right"
