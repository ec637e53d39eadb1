# Run in a clean system: a package is installed, upgraded, downgraded, removed and purged, and nothing that a person
# changed is lost before the last step.
#
# lifecycle.sh NAME PROGRAM DEB VERSION NEWER_DEB NEWER_VERSION
name=$1 program=$2 deb=/trial/$3 version=$4 newer_deb=/trial/$5 newer_version=$6
conffile=/etc/default/$name
state=/var/lib/sextant/camera-north.toml

fail() {
    echo "$name: $*" >&2
    exit 1
}

# is_installed VERSION: and its program starts on this system.
is_installed() {
    found=$(dpkg-query --show --showformat '${Status} ${Version}' "$name")
    test "$found" = "install ok installed $1-1" || fail "dpkg says '$found' in place of $1"
    "$program" --version > /dev/null || fail "$program does not start"
}

keeps_changes() {
    grep -q debug "$conffile" || fail "$conffile is no longer as it was changed"
    grep -q demo "$state" || fail "$state is no longer as it was"
}

gone() {
    for path; do
        test ! -e "$path" || fail "$path is left behind"
    done
}

dpkg --install "$deb"
is_installed "$version"
test -d /var/lib/sextant || fail "/var/lib/sextant is missing"
grep -q ^sextant: /etc/passwd || fail "there is no user sextant"
echo SEXTANT_LOG=debug > "$conffile"
echo 'site = "demo"' > "$state"

dpkg --force-confold --install "$newer_deb"
is_installed "$newer_version"
keeps_changes
dpkg --force-confold,downgrade --install "$deb"
is_installed "$version"
keeps_changes

dpkg --remove "$name"
gone "/usr/bin/$program"
keeps_changes
dpkg --purge "$name"
gone "$conffile" /var/lib/sextant /var/lib/sextant-viewer
