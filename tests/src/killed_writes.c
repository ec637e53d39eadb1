/* Preloaded into a process, kills it (SIGKILL) before a call that would change the disk: the KILL_AT-th one on files
   below KILL_IN, counted from when the file KILL_ARMED is there. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

static int calls;

static void count(const char *path)
{
    const char *folder = getenv("KILL_IN"), *armed = getenv("KILL_ARMED"), *at = getenv("KILL_AT");
    if (!folder || !armed || !at || !path || strncmp(path, folder, strlen(folder)) != 0)
        return;
    if (syscall(SYS_access, armed, F_OK) != 0)
        return;
    if (__sync_add_and_fetch(&calls, 1) == atoi(at))
        kill(getpid(), SIGKILL);
}

static void count_descriptor(int descriptor)
{
    char name[64], path[PATH_MAX];
    snprintf(name, sizeof name, "/proc/self/fd/%d", descriptor);
    ssize_t length = readlink(name, path, sizeof path - 1);
    if (length > 0) {
        path[length] = 0;
        count(path);
    }
}

static int opened(const char *path, int flags, mode_t mode)
{
    if (flags & (O_CREAT | O_TRUNC))
        count(path);
    return (int)syscall(SYS_openat, AT_FDCWD, path, flags, mode);
}

int open(const char *path, int flags, ...)
{
    va_list rest;
    va_start(rest, flags);
    mode_t mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(rest, mode_t) : 0;
    va_end(rest);
    return opened(path, flags, mode);
}

int open64(const char *path, int flags, ...)
{
    va_list rest;
    va_start(rest, flags);
    mode_t mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(rest, mode_t) : 0;
    va_end(rest);
    return opened(path, flags | O_LARGEFILE, mode);
}

ssize_t write(int descriptor, const void *bytes, size_t length)
{
    count_descriptor(descriptor);
    return syscall(SYS_write, descriptor, bytes, length);
}

int fsync(int descriptor)
{
    count_descriptor(descriptor);
    return (int)syscall(SYS_fsync, descriptor);
}

int rename(const char *from, const char *to)
{
    count(from);
    return (int)syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0);
}

int unlink(const char *path)
{
    count(path);
    return (int)syscall(SYS_unlinkat, AT_FDCWD, path, 0);
}
