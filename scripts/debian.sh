# Shell functions of the other scripts: what is missing, and how to install it. To be sourced.

# need_commands COMMAND:PACKAGE ...: installs the packages of the commands that are not there.
need_commands() {
    missing=
    for pair in "$@"; do
        command -v "${pair%%:*}" >/dev/null 2>&1 || missing="$missing ${pair#*:}"
    done
    install_packages $missing
}

# need_files FILE:PACKAGE ...: the same for files.
need_files() {
    missing=
    for pair in "$@"; do
        [ -e "${pair%%:*}" ] || missing="$missing ${pair#*:}"
    done
    install_packages $missing
}

install_packages() {
    [ $# -gt 0 ] || return 0
    if ! command -v apt-get >/dev/null 2>&1; then
        echo "missing, and there is no apt-get to install them: $*" >&2
        return 1
    fi
    as_root=
    if [ "$(id -u)" -ne 0 ]; then
        if ! command -v sudo >/dev/null 2>&1; then
            echo "missing, and there is neither root nor sudo to install them: $*" >&2
            return 1
        fi
        as_root=sudo
    fi
    echo "installing: $*"
    $as_root apt-get update -q &&
        $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends "$@"
}

need_rust() {
    [ -x "$HOME/.cargo/bin/cargo" ] && PATH="$PATH:$HOME/.cargo/bin"
    if ! command -v cargo >/dev/null 2>&1; then
        echo "there is no cargo: install Rust 1.89 or later first" >&2
        return 1
    fi
}
