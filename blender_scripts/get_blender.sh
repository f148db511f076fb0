#!/usr/bin/env bash
# A real Blender with a window, from Debian's packages, in a folder of its own: get_blender.sh FOLDER SUITE
# SUITE: a Debian suite, as trixie (Blender 4.3) or sid (the newest). Unpacks packages without installing any: the machine's
# own packages and settings stay as they are. Needs root (chroot, mknod), apt and dpkg. Holds no test and starts nothing.
set -euo pipefail

folder=$(realpath -m "$1")
suite=$2
apt_state=$folder.apt
packages=(
    blender xvfb libgl1-mesa-dri libegl1 libgl1 libegl-mesa0 libglx-mesa0 libc-bin base-files dash coreutils
    # What Blender's extension machinery and numpy users need, and Debian only recommends.
    python3-cattr python3-requests python3-zstandard python3-numpy
)

# The mirror that this machine's apt uses.
mirror=$(apt-get indextargets --format '$(REPO_URI)' | grep -m1 '/debian/$')
rm -rf "$folder" "$apt_state"
mkdir -p "$folder" "$apt_state"/{lists/partial,cache/archives/partial}
: > "$apt_state/status"
echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] $mirror $suite main" > "$apt_state/sources.list"
cat > "$apt_state/apt.conf" <<END
Dir::Etc::sourcelist "$apt_state/sources.list";
Dir::Etc::sourceparts "-";
Dir::Etc::preferencesparts "-";
Dir::State "$apt_state";
Dir::State::lists "$apt_state/lists";
Dir::State::status "$apt_state/status";
Dir::Cache "$apt_state/cache";
Acquire::Languages "none";
Acquire::Retries "3";
APT::Install-Recommends "false";
APT::Sandbox::User "root";
END
export APT_CONFIG=$apt_state/apt.conf DEBIAN_FRONTEND=noninteractive
apt-get update -qq
apt-get install -y -qq --download-only "${packages[@]}" > "$apt_state/download.log" 2>&1 || { tail -5 "$apt_state/download.log"; exit 1; }

mkdir -p "$folder"/usr/{bin,sbin,lib,lib64}
for name in bin sbin lib lib64; do ln -sfn "usr/$name" "$folder/$name"; done
for package in "$apt_state"/cache/archives/*.deb; do
    dpkg-deb --fsys-tarfile "$package" | tar -x -C "$folder" --keep-directory-symlink \
        --exclude=./usr/share/doc --exclude=./usr/share/man --exclude=./usr/share/locale
done
rm -rf "$apt_state"

# What the packages' own scripts would have made.
mkdir -p "$folder"/{proc,tmp,root,etc,dev/shm} && chmod 1777 "$folder/tmp" "$folder/dev/shm"
mkdir -p "$folder/tmp/.X11-unix" && chmod 1777 "$folder/tmp/.X11-unix"
while read -r name minor; do
    rm -f "$folder/dev/$name"
    mknod -m 666 "$folder/dev/$name" c 1 "$minor"
done <<< $'null 3\nzero 5\nfull 7\nrandom 8\nurandom 9'
ln -sfn /proc/mounts "$folder/etc/mtab"
echo 'root:x:0:0:root:/root:/bin/sh' > "$folder/etc/passwd"
echo 'root:x:0:' > "$folder/etc/group"
[ -e "$folder/usr/bin/sh" ] || ln -s dash "$folder/usr/bin/sh"
libraries=$folder/usr/lib/x86_64-linux-gnu
for pair in libblas.so.3:blas liblapack.so.3:lapack; do
    [ -e "$libraries/${pair%%:*}" ] || ln -s "${pair##*:}/${pair%%:*}" "$libraries/${pair%%:*}"
done
chroot "$folder" /usr/sbin/ldconfig 2>/dev/null || true
chroot "$folder" /usr/bin/env -i PATH=/usr/bin HOME=/root blender --version 2>/dev/null | head -1
