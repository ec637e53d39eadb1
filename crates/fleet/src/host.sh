# Runs on a host of the fleet, as root, in the shells of Debian and BusyBox: `sextant deploy` sends it.
#
#   look NAME KEYS           prints what is there, a line each: a word, then its value
#   apply NAME KEYS FOLDER SECONDS
#                            puts what the folder has in force, then waits for a line on standard input. `keep`
#                            keeps it; anything else, the end of the connection or SECONDS without a word bring back
#                            what was there before.
#
# NAME is the camera, KEYS the folder of its keys below the state folder, or `-`. A host is changed by one program at a
# time. What was there before lies in FORMER, complete, from before the first change until the new state is kept or the
# old one is back: where it exists at the start, an earlier run was cut off, by a power failure say, and is undone
# first.
set -u
umask 077

PACKAGE=sextant-camera
PROGRAM=/usr/bin/node-camera
BASE=/var/lib/sextant-deploy
ACTION=$1
NAME=$2
OWN=$BASE/$NAME
FORMER=$OWN/former
LOG=$OWN/log
UNITS="sextant-capture@$NAME sextant-detect@$NAME"
INIT_SCRIPT=/etc/init.d/S90sextant-camera
if [ -d /run/systemd/system ]; then
    INIT=systemd
    STATE=/var/lib/sextant
else
    INIT=busybox
    STATE=/etc/sextant
fi
CONFIG=$STATE/camera-$NAME.toml

say() { echo "$@" 2>/dev/null || :; }
has() { command -v "$1" >/dev/null 2>&1; }
digest() { sha256sum "$1" 2>/dev/null | cut -d ' ' -f 1; }

# --- what is there ---

c_library() {
    version=$(getconf GNU_LIBC_VERSION 2>/dev/null) && [ -n "$version" ] && echo "$version" && return
    for file in /lib/ld-musl-*; do [ -e "$file" ] && echo musl && return; done
    for file in /lib/libc.so.6 /lib/*/libc.so.6 /lib64/libc.so.6; do
        [ -x "$file" ] || continue
        version=$("$file" 2>/dev/null | sed -n '1s/.*version \([0-9.]*[0-9]\).*/\1/p')
        [ -n "$version" ] && echo "glibc $version" && return
    done
    echo unknown
}

# `ii` with the version, or another state of dpkg's, or nothing.
package_state() { dpkg-query --show --showformat '${db:Status-Abbrev} ${Version}' "$PACKAGE" 2>/dev/null; }

is_active() {
    if [ "$INIT" = systemd ]; then
        for unit in $UNITS; do systemctl is-active --quiet "$unit" || return 1; done
    else
        kill -0 "$(cat "/run/sextant-pids/camera-$NAME" 2>/dev/null)" 2>/dev/null
    fi
}

look() {
    say machine "$(uname -m)"
    # 64-bit kernels run 32-bit systems: the programs of the system count. Byte 4 of theirs is 1 or 2.
    say bits "$(od -A n -t u1 -j 4 -N 1 /proc/self/exe | tr -d ' ')"
    grep -q -w neon /proc/cpuinfo && say neon yes
    say libc "$(c_library)"
    say init "$INIT"
    has dpkg && say dpkg "$(dpkg --print-architecture)"
    [ -w /usr/bin ] && say writable yes
    has dpkg && say package "$(package_state)"
    [ -f "$PROGRAM" ] && say program "$(digest "$PROGRAM")"
    [ -f "$BASE/record" ] && cat "$BASE/record"
    [ -f "$CONFIG" ] && say file camera.toml "$(digest "$CONFIG")"
    if [ "$1" != - ]; then
        for file in "$STATE/$1"/*; do
            [ -f "$file" ] && say file "keys/${file##*/}" "$(digest "$file")"
        done
    fi
    is_active && say active yes
    [ -d "$FORMER" ] && say interrupted yes
    say end
}

# --- starting and stopping ---

# Not with our descriptors: what is started outlives this script.
start() {
    if [ "$INIT" = systemd ]; then
        systemctl daemon-reload
        # shellcheck disable=SC2086
        systemctl enable $UNITS && systemctl restart $UNITS
    else
        "$INIT_SCRIPT" start
    fi
}

stop() {
    if [ "$INIT" = systemd ]; then
        for unit in $UNITS; do
            systemctl is-active --quiet "$unit" && { systemctl stop "$unit" || return 1; }
        done
        return 0
    elif [ -x "$INIT_SCRIPT" ]; then
        "$INIT_SCRIPT" stop
    fi
}

# --- packages ---

# A package of what is installed, since dpkg keeps none.
repack() {
    tree=$OWN/repack
    rm -rf "$tree" && mkdir -p "$tree/DEBIAN" && chmod 755 "$tree" "$tree/DEBIAN" || return 1
    dpkg-query --listfiles "$PACKAGE" | while read -r file; do
        if [ -d "$file" ] && [ ! -L "$file" ]; then
            mkdir -p "$tree$file" || exit 1
        elif [ -e "$file" ] || [ -L "$file" ]; then
            cp -a "$file" "$tree$file" || exit 1
        fi
    done || return 1
    for part in preinst postinst prerm postrm conffiles; do
        file=$(dpkg-query --control-path "$PACKAGE" "$part" 2>/dev/null)
        [ -n "$file" ] && { cp "$file" "$tree/DEBIAN/$part" || return 1; }
    done
    dpkg-query --status "$PACKAGE" |
        awk '/^Status:/ { next } /^Conffiles:/ { skip = 1; next } /^ / && skip { next } { skip = 0; print }' \
            >"$tree/DEBIAN/control"
    chmod -R u+rwX,go+rX "$tree" && dpkg-deb -Znone --build "$tree" "$1" && rm -rf "$tree"
}

install_deb() { DEBIAN_FRONTEND=noninteractive dpkg --force-confold --force-confdef --install "$1"; }

save_package() {
    if [ -f "$FOLDER/package.deb" ]; then
        state=$(package_state)
        case $state in
        ii\ * | hi\ *) repack "$1/package.deb" ;;
        '' | un* | rc*) : ;;
        *)
            CAUSE="package $PACKAGE is half installed ($state): run dpkg --configure -a or dpkg --purge $PACKAGE there"
            return 1
            ;;
        esac
    elif [ -f "$FOLDER/package.tar.gz" ]; then
        tar -t -z -f "$FOLDER/package.tar.gz" >"$1/files" && : >"$1/present" || return 1
        while read -r file; do
            [ -f "/$file" ] && echo "$file" >>"$1/present"
        done <"$1/files"
        # BusyBox reads no list of an empty archive.
        [ ! -s "$1/present" ] || tar -c -f "$1/package.tar" -C / -T "$1/present"
    fi
}

install_package() {
    if [ -f "$FOLDER/package.deb" ]; then
        install_deb "$FOLDER/package.deb"
    elif [ -f "$FOLDER/package.tar.gz" ]; then
        tar -x -z -f "$FOLDER/package.tar.gz" -C / || return 1
        # What a person changed stays as it is.
        grep '^etc/default/' "$FORMER/present" >"$FORMER/kept" || return 0
        tar -x -f "$FORMER/package.tar" -C / -T "$FORMER/kept"
    fi
}

restore_package() {
    if [ -f "$FORMER/package.deb" ]; then
        install_deb "$FORMER/package.deb"
    elif [ -f "$FORMER/files" ]; then
        while read -r file; do
            [ -f "/$file" ] && ! grep -q -x "$file" "$FORMER/present" && rm -f "/$file"
        done <"$FORMER/files"
        [ ! -s "$FORMER/present" ] || tar -x -f "$FORMER/package.tar" -C /
    elif [ -f "$FORMER/absent" ]; then
        case $(package_state) in '' | un* | rc*) : ;; *) dpkg --force-remove-reinstreq --remove "$PACKAGE" ;; esac
    fi
}

# --- configuration and keys ---

# Puts a copy in the place of a file or folder, whole from one moment to the next; removes it where the copy's origin is
# missing.
replace() {
    from=$1 to=$2
    rm -rf "$to.new" "$to.old" || return 1
    if [ -e "$from" ]; then
        mkdir -p "${to%/*}" && cp -a "$from" "$to.new" || return 1
        if grep -q '^sextant:' /etc/passwd; then chown -R sextant: "$to.new" || return 1; fi
    fi
    # A folder cannot be renamed onto one.
    if [ -d "$to" ]; then mv "$to" "$to.old" || return 1; fi
    if [ -e "$to.new" ]; then mv "$to.new" "$to"; else rm -f "$to"; fi && rm -rf "$to.old"
}

configure() {
    owner=root
    grep -q '^sextant:' /etc/passwd && owner=sextant
    mkdir -p "$STATE" && chown "$owner" "$STATE" && replace "$1/camera.toml" "$CONFIG" || return 1
    if [ "$KEYS" != - ]; then
        # The folders between are the unit's, too.
        mkdir -p "$STATE/${KEYS%/*}" && chown "$owner" "$STATE/${KEYS%/*}" && replace "$1/keys" "$STATE/$KEYS"
    fi
}

# --- the change and its undoing ---

save() {
    fresh=$OWN/former.new
    rm -rf "$fresh" && mkdir -p "$fresh" || return 1
    is_active && : >"$fresh/active"
    if [ "$INIT" = systemd ]; then
        for unit in $UNITS; do systemctl is-enabled --quiet "$unit" 2>/dev/null && echo "$unit" >>"$fresh/enabled"; done
    fi
    if [ -f "$CONFIG" ]; then cp -a "$CONFIG" "$fresh/camera.toml" || return 1; fi
    if [ "$KEYS" != - ] && [ -d "$STATE/$KEYS" ]; then cp -a "$STATE/$KEYS" "$fresh/keys" || return 1; fi
    echo "$KEYS" >"$fresh/keys-folder"
    save_package "$fresh" || return 1
    [ -f "$FOLDER/package.deb" ] && [ ! -f "$fresh/package.deb" ] && : >"$fresh/absent"
    sync && mv "$fresh" "$FORMER"
}

# One step: its name, what it is when it fails, the command.
step() {
    say step "$1"
    CAUSE=$2
    shift 2
    quietly "$@"
}

change() {
    step stopping "the units do not stop" stop &&
        { [ ! -f "$FOLDER/package.sha256" ] || step installing "the package cannot be installed" install_package; } &&
        step configuring "the configuration cannot be written" configure "$FOLDER" &&
        step starting "the units do not start" start
}

restore() {
    KEYS=$(cat "$FORMER/keys-folder") || return 1
    stop
    restore_package && configure "$FORMER" || return 1
    if [ "$INIT" = systemd ]; then
        for unit in $UNITS; do
            grep -q -x -s "$unit" "$FORMER/enabled" || systemctl disable "$unit"
        done
        systemctl daemon-reload
    fi
    if [ -f "$FORMER/active" ]; then start || return 1; fi
    sync && rm -rf "$FORMER"
}

# The first line of standard input, waited for SECONDS; empty at its end.
answer() {
    rm -f "$OWN/answer" "$OWN/answered"
    (
        head -n 1 <&3 >"$OWN/answer"
        : >"$OWN/answered"
    ) 9>&- >/dev/null 2>&1 &
    left=$1
    while [ ! -e "$OWN/answered" ] && [ "$left" -gt 0 ]; do
        sleep 1
        left=$((left - 1))
    done
    cat "$OWN/answer"
}

last_words() {
    if [ "$INIT" = systemd ]; then
        for unit in $UNITS; do journalctl --no-pager --output cat --lines 8 --unit "$unit" 2>/dev/null; done
    elif has logread; then
        logread 2>/dev/null | grep sextant-camera | tail -n 12
    else
        grep -h sextant-camera /var/log/messages /var/log/syslog 2>/dev/null | tail -n 12
    fi
}

log_lines() { tail -n 12 "$LOG" | while read -r line; do say log "$line"; done; }

# Brings back what was there before, and says what the log has.
undo() {
    [ -z "$CAUSE" ] || say cause "$CAUSE"
    log_lines
    last_words | while read -r line; do say log "$line"; done
    if step restoring "" restore; then
        say outcome former
    else
        log_lines
        say outcome broken
    fi
}

# Output of programs goes to the log, ours to the other end; nothing that is started keeps the lock or standard input.
quietly() { "$@" >>"$LOG" 2>&1 3<&- 9>&- </dev/null; }

apply() {
    FOLDER=$1
    echo "$$" >"$FOLDER/process"
    exec 3<&0 9>"$BASE/lock"
    if has flock && ! flock -n 9; then
        say step waiting for another deployment to this host
        flock 9
    fi
    : >"$LOG"
    if [ ! -f "$FOLDER/camera.toml" ] || { [ "$KEYS" != - ] && [ ! -d "$FOLDER/keys" ]; }; then
        say cause "what was copied is gone or not whole: run the deployment again"
        say outcome untouched
        return
    fi
    if [ -d "$FORMER" ]; then
        step restoring "an earlier deployment was cut off and cannot be undone" restore || {
            say cause "$CAUSE"
            log_lines
            say outcome broken
            return
        }
    fi
    step saving "the present state cannot be saved" save || {
        say cause "$CAUSE"
        log_lines
        say outcome untouched
        return
    }
    if change; then
        CAUSE=
        say step waiting
        if [ "$(answer "$2")" = keep ]; then
            is_active && keep && return
            CAUSE="the units are not active"
        fi
    fi
    undo
}

keep() {
    if [ -f "$FOLDER/package.sha256" ]; then
        echo "deployed $(cat "$FOLDER/package.sha256") $(digest "$PROGRAM")" >"$BASE/record.new" &&
            mv "$BASE/record.new" "$BASE/record"
    fi
    sync
    rm -rf "$FORMER"
    say outcome new
}

# Removes our own stage, and those of deployments that ended without it; others may wait for the lock.
clean() {
    rm -rf "$FOLDER" "$OWN"/answer*
    for stage in "$OWN"/stage.*; do
        [ -f "$stage/process" ] && ! kill -0 "$(cat "$stage/process")" 2>/dev/null && rm -rf "$stage"
    done
}

# A lost connection or Ctrl-C at the other end must not cut this short. Not ignored: what is started would ignore them
# as well, for good.
trap : HUP INT TERM PIPE
case $ACTION in
look) look "$3" ;;
apply)
    KEYS=$3
    apply "$4" "$5"
    clean
    ;;
esac
