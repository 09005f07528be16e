#!/bin/sh
# /usr/local/bin/balise: a command as the service would run it, with its account, settings, secrets and data. For root.
set -eu
set -a
[ ! -f /etc/balise/balise.env ] || . /etc/balise/balise.env
for secret in /etc/balise/secrets/*; do
    [ ! -f "$secret" ] || export "BALISE_$(basename "$secret" | tr a-z A-Z)=$(cat "$secret")"
done
HOME=/var/lib/balise
BALISE_DATA_DIR=/var/lib/balise
exec runuser --user balise -- /opt/balise/bin/balise "$@"
