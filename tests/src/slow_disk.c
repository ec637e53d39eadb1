/* Preloaded into a process, makes its writes to disk slow: each fsync takes seven tenths of a second more. */
#include <sys/syscall.h>
#include <unistd.h>

int fsync(int descriptor)
{
    usleep(700000);
    return (int)syscall(SYS_fsync, descriptor);
}
