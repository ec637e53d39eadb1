#!/bin/sh
# Makes the emulated board's files in $BOARD from Debian's packages, which mmdebstrap has unpacked in $1: kernel, device
# tree, initial RAM file system and disk. Runs no program of the board's processor: packages stay unpacked, none of
# their scripts is run.
set -eu
root=$1
files=$(dirname "$0")
: >"$BOARD/unpacked"

# dpkg is to know what is there, so that it can resolve what a package of ours depends on.
database=$root/var/lib/dpkg
for deb in "$root"/var/cache/apt/archives/*.deb; do
    name=$(dpkg-deb --field "$deb" Package)
    {
        printf 'Package: %s\nStatus: install ok installed\n' "$name"
        dpkg-deb --field "$deb" | grep -v '^Package:'
        echo
    } >>"$database/status"
    [ "$(dpkg-deb --field "$deb" Multi-Arch)" != same ] || name=$name:$(dpkg-deb --field "$deb" Architecture)
    : >"$database/info/$name.list"
    rm "$deb"
done

cp "$root/usr/share/base-passwd/passwd.master" "$root/etc/passwd"
cp "$root/usr/share/base-passwd/group.master" "$root/etc/group"
echo board >"$root/etc/hostname"
echo 0123456789abcdef0123456789abcdef >"$root/etc/machine-id"
cp -r "$files/root/." "$root"
system=$root/etc/systemd/system
mkdir -p "$system/multi-user.target.wants"
ln -s /usr/lib/systemd/system/multi-user.target "$system/default.target"
for unit in /etc/systemd/system/board-agent.service /usr/lib/systemd/system/systemd-networkd.service; do
    ln -s "$unit" "$system/multi-user.target.wants/"
done
# What only costs an emulated processor time.
while read -r unit; do ln -s /dev/null "$system/$unit"; done <"$files/masked-units"

version=$(ls "$root/lib/modules")
depmod --basedir "$root" "$version"
cp "$root/boot/vmlinuz-$version" "$BOARD/kernel"
cp "$root/usr/lib/linux-image-$version/vexpress-v2p-ca9.dtb" "$BOARD/device-tree"
rm -rf "${root:?}/boot" "$root/usr/lib/linux-image-$version"

initramfs=$BOARD/initramfs.d
mkdir -p "$initramfs/modules" "$initramfs/bin" "$initramfs/dev" "$initramfs/root"
cp "$files/init" "$initramfs/"
cp "$root/usr/bin/busybox" "$initramfs/bin/"
number=10
for module in crypto/crc32c_generic drivers/virtio/virtio_mmio drivers/block/virtio_blk lib/crc16 fs/mbcache \
    fs/jbd2/jbd2 fs/ext4/ext4; do
    cp "$root/lib/modules/$version/kernel/$module.ko" "$initramfs/modules/$number-$(basename "$module").ko"
    number=$((number + 1))
done
(cd "$initramfs" && find . | cpio --create --format newc --quiet --owner 0:0 | gzip -1) >"$BOARD/initramfs"
rm -r "$initramfs"

# mmdebstrap has these mounted.
for folder in proc sys dev; do umount --lazy "$root/$folder" 2>/dev/null || true; done
mke2fs -q -t ext4 -O ^has_journal -d "$root" "$BOARD/disk" 800M
