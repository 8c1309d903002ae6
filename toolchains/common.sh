# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# Functions that ./run and ./test share. Needs $root, the project's folder, and $self, the name to speak under.
# Everything goes to stderr: stdout belongs to the program that is run.

say() { printf '%s: %s\n' "$self" "$*" >&2; }

# refuse TEXT...: bad usage or a missing package.
refuse() {
    say "$@"
    exit 2
}

# tier_packages TIER...: the packages of these tiers, one a line.
tier_packages() {
    local tier
    for tier in "$@"; do
        sed -e 's/#.*//' -e 's/[[:space:]]//g' -e '/^$/d' "$root/packages/$tier.txt"
    done
}

# missing_packages TIER...: those of them that are not installed.
missing_packages() {
    local wanted
    wanted=$(tier_packages "$@")
    [[ -n $wanted ]] || return 0
    # shellcheck disable=SC2086  # one word a package
    comm -23 <(sort -u <<<"$wanted") \
        <(dpkg-query -W -f='${db:Status-Status} ${Package}\n' $wanted 2>/dev/null | sed -n 's/^installed //p' | sort -u)
}

# install_size PACKAGE...: what apt would fetch and unpack, in its own words; empty if it cannot tell.
install_size() {
    LC_ALL=C apt-get install --assume-no --no-install-recommends -o Debug::NoLocking=true "$@" 2>/dev/null |
        grep -E '^(Need to get|After this operation)' | tr '\n' ' ' || true
}

# require_tiers TIER...: installs what is missing. Without root it prints the command and exits with 2.
require_tiers() {
    command -v dpkg-query >/dev/null ||
        refuse "this system has no Debian packages; install the like of: $(tier_packages "$@" | tr '\n' ' ')"
    local missing command size
    mapfile -t missing < <(missing_packages "$@")
    ((${#missing[@]})) || return 0
    command="apt-get install -y --no-install-recommends ${missing[*]}"
    say "${#missing[@]} packages of the tiers '$*' are missing"
    if ((EUID != 0)); then
        size=$(install_size "${missing[@]}")
        [[ -z $size ]] || say "$size"
        refuse "install them, as root: apt-get update && $command"
    fi
    apt-get update -qq >&2 || say "the package lists could not be refreshed; trying with those that are there"
    size=$(install_size "${missing[@]}")
    say "${size:-their size is unknown}"
    DEBIAN_FRONTEND=noninteractive $command -qq </dev/null >&2 ||
        refuse "the packages could not be installed; the command was: $command"
}

# build PRESET [TARGET...]: configures and builds quietly. Prints nothing when there is nothing to do, $build_note when
# there is, and the whole log on failure. Uses $configure_options, more options of cmake.
configure_options=()
build_note=
build() {
    local preset=$1 log=$root/build/$1.log
    mkdir -p "$root/build"
    exec 9>"$root/build/.$preset.lock"
    flock 9
    if ! build_steps "$@" 3>&2 >"$log" 2>&1 9>&-; then
        cat "$log" >&2
        say "the build of '$preset' failed; the log is above and in build/$preset.log"
        return 1
    fi
    exec 9>&-
}
build_steps() {
    local preset=$1 dir=$root/build/$1
    shift
    configure "$preset" "$dir" || return 1
    if [[ -n $build_note ]] && ! ninja -C "$dir" -n "$@" | grep -q 'no work to do'; then
        printf '%s: %s\n' "$self" "$build_note" >&3
    fi
    ninja -C "$dir" "$@"
}

# configure PRESET DIR: only when the folder is new or moved, or a list or preset has changed since.
configure() {
    local preset=$1 dir=$2 stamp=$2/.configured asked
    asked=$(printf '%s\n' "$root" ${configure_options[@]+"${configure_options[@]}"})
    if [[ -f $stamp ]]; then
        [[ $(head -n 1 "$stamp") == "$root" ]] || rm -rf "$dir"
        [[ $(cat "$stamp" 2>/dev/null) != "$asked" || -n $(lists_newer_than "$stamp") ]] || return 0
    fi
    (cd "$root" && cmake --preset "$preset" ${configure_options[@]+"${configure_options[@]}"}) &&
        printf '%s\n' "$asked" >"$stamp"
}
lists_newer_than() {
    find "$root" -name 'build*' -prune -o -name .git -prune -o -newer "$1" \
        \( -name 'CMakeLists.txt' -o -name 'CMakePresets.json' -o -name '*.cmake' \) -print -quit
}
