# Makes .venv-bench, for the starters of the benchmarks, which source this in the project's folder.
#
# Packages stay until their pins change. Those that everything stands on must install; of the
# peers, those that do not are noted.

environment() {
    local folder=.venv-bench requirements=scripts/requirements-bench.txt python stamp line
    python=$(command -v python3.11 || command -v python3)
    stamp=$({ pwd && "$python" --version && cat "$requirements"; } | sha256sum)
    [[ -f $folder/stamp && $(<"$folder/stamp") == "$stamp" ]] && return
    rm -rf "$folder"
    "$python" -m venv "$folder"
    local install=("$folder/bin/pip" install --quiet --disable-pip-version-check)
    local base peers
    base=$(sed -n '/^# Peers/q;/^[^#]/p' "$requirements")
    peers=$(sed -n '/^# Peers/,$p' "$requirements" | grep -v '^#')
    echo "installing packages into $folder" >&2
    # shellcheck disable=SC2086 # one word each
    "${install[@]}" $base
    : >"$folder/absent"
    for line in $peers; do
        "${install[@]}" "$line" 2>"$folder/log" \
            || echo "${line%%=*}: not installed: $(grep -m 1 ERROR "$folder/log")" \
                >>"$folder/absent"
    done
    echo "$stamp" >"$folder/stamp"
}
