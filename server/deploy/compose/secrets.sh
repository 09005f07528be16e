#!/bin/sh
# Makes the secrets that compose.yaml asks for, once: what is there already stays.
set -eu
umask 077
folder=${1:-$(dirname "$0")/secrets}
mkdir -p "$folder"
random() { head -c 24 /dev/urandom | base64 | tr -d '=+/\n'; }
keep() { [ -s "$folder/$1" ] || printf '%s\n' "$2" >"$folder/$1"; }
keep postgres_password "$(random)"
keep balise_nats_token "$(random)"
keep balise_metrics_token "$(random)"
keep nats_auth "token: \"$(cat "$folder/balise_nats_token")\""
keep balise_database_url "postgresql://balise:$(cat "$folder/postgres_password")@postgres/balise"
# Those that the container reads belong to its user, where this is run by root.
[ "$(id -u)" -ne 0 ] || chown 10001:10001 "$folder"/balise_*
[ "$(id -u)" -ne 0 ] || chown 10002:10002 "$folder/nats_auth"
