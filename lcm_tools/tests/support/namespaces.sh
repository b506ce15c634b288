# Sourced by scripts that want networks and mounts of their own. Sets `own` to the options by which unshare gives them here:
# a user does it in a user namespace, root in a chroot or a container with its rights without one. Empty: this system forbids it.
own=""
for try in -rmn -mn; do
  if unshare $try true 2>/dev/null; then own=$try; break; fi
done
