/* Lets user-mode-linux boot on processors with AMX; preloaded by amx.py.
 *
 * The guest's kernel sets its processes' floating-point registers through ptrace, with room for the
 * extensions up to AVX-512. On a processor with AMX the area is longer, and Linux refuses a shorter
 * one with EFAULT. Here such a request first gets the whole area, lays the shorter one over its
 * beginning and sets the whole. Every other request goes to the system call as it is. */
#include <errno.h>
#include <stdarg.h>
#include <string.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

enum { PEEKTEXT = 1, PEEKDATA = 2, PEEKUSER = 3, GETREGSET = 0x4204, SETREGSET = 0x4205 };
#define X86_XSTATE ((void *)0x202)

static long set_xstate(long process, const struct iovec *shorter)
{
    /* Static: the guest calls from small stacks of its own, and from one thread. */
    static char area[1 << 16];
    struct iovec whole = {area, sizeof area};
    if (syscall(SYS_ptrace, (long)GETREGSET, process, X86_XSTATE, &whole) < 0)
        return -1;
    if (shorter->iov_len > whole.iov_len)
        whole = *shorter;
    else
        memcpy(area, shorter->iov_base, shorter->iov_len);
    return syscall(SYS_ptrace, (long)SETREGSET, process, X86_XSTATE, &whole);
}

long ptrace(int request, ...)
{
    va_list arguments;
    va_start(arguments, request);
    long process = va_arg(arguments, int);
    void *address = va_arg(arguments, void *);
    void *data = va_arg(arguments, void *);
    va_end(arguments);
    if (request == SETREGSET && address == X86_XSTATE)
        return set_xstate(process, data);
    if (request >= PEEKTEXT && request <= PEEKUSER) {
        /* The system call stores the word; the function returns it. */
        long word = 0;
        if (syscall(SYS_ptrace, (long)request, process, address, &word) < 0)
            return -1;
        errno = 0;
        return word;
    }
    return syscall(SYS_ptrace, (long)request, process, address, data);
}
