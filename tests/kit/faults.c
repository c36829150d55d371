/* Fails one file call of a process, below one folder: loaded by LD_PRELOAD, and armed by fault_arm().
 *
 * Calls that open, read, write, resize, sync, rename and remove files are counted, those of SQLite and of Python alike;
 * of all kinds but FAIL only those that change something, as a kill before a call leaves what one after the last left.
 * The one of number `at` fails as its kind says; fault_calls() gives what calls there were.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <unistd.h>

enum { NONE, FAIL, SHORT, FULL, KILL, TORN };

static int kind = NONE, at = -1, count = 0, armed = 0;
static char root[4096];

void fault_arm(int new_kind, int new_at, const char *folder) {
    kind = new_kind, at = new_at, count = 0, armed = 1;
    snprintf(root, sizeof root, "%s/", folder);
}

static int below(const char *path) { return armed && path != NULL && strncmp(path, root, strlen(root)) == 0; }

static int is_ours(int fd) {
    char link[64], path[4096];
    if (!armed) return 0;
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t length = readlink(link, path, sizeof path - 2);
    if (length < 0) return 0;
    path[length] = '/', path[length + 1] = 0;
    return below(path);
}

static void die(void) { kill(getpid(), SIGKILL); pause(); }

enum { READS, CHANGES, TAKES_SPACE };

static char calls[1 << 16];

/* The calls that were counted, in order: the name of each, and whether it only reads, one a line. */
const char *fault_calls(void) { return calls; }

/* Whether this call must fail, with errno; a full disk refuses every call that takes space from then on. */
static int fails(int effect, const char *name) {
    if (effect == READS && kind != FAIL) return 0;
    count++;
    size_t used = strlen(calls);
    snprintf(calls + used, sizeof calls - used, "%s %d\n", name, effect == READS);
    if (kind == FULL && count >= at && effect == TAKES_SPACE) { errno = ENOSPC; return 1; }
    if (kind == FAIL && count == at) { errno = EIO; return 1; }
    return 0;
}

static void passed(int effect) { if (kind == KILL && count == at && effect != READS) die(); }

#define REAL(name) static __typeof__(name) *real; if (!real) real = (__typeof__(name) *)dlsym(RTLD_NEXT, #name)

#define CALL(name, type, arguments, passed_on, ours, effect) \
    type name arguments { \
        REAL(name); \
        if (!(ours)) return real passed_on; \
        if (fails(effect, #name)) return -1; \
        type result = real passed_on; \
        int kept = errno; \
        passed(effect); \
        errno = kept; \
        return result; \
    }

#define WRITE(name, arguments, passed_on, halved) \
    ssize_t name arguments { \
        REAL(name); \
        if (!is_ours(fd)) return real passed_on; \
        if (fails(TAKES_SPACE, #name)) return -1; \
        if (count == at && (kind == SHORT || kind == TORN) && size > 1) { \
            ssize_t half = real halved; \
            if (kind == TORN) die(); \
            return half; \
        } \
        ssize_t result = real passed_on; \
        passed(TAKES_SPACE); \
        return result; \
    }

#define OPEN(name) \
    int name(const char *path, int flags, ...) { \
        REAL(name); \
        va_list rest; \
        va_start(rest, flags); \
        mode_t mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(rest, mode_t) : 0; \
        va_end(rest); \
        if (!below(path)) return real(path, flags, mode); \
        int effect = flags & O_CREAT && access(path, F_OK) != 0 ? TAKES_SPACE : READS; \
        if (fails(effect, #name)) return -1; \
        int result = real(path, flags, mode), kept = errno; \
        passed(effect); \
        errno = kept; \
        return result; \
    }

OPEN(open)
OPEN(open64)
WRITE(write, (int fd, const void *data, size_t size), (fd, data, size), (fd, data, size / 2))
WRITE(pwrite, (int fd, const void *data, size_t size, off_t to), (fd, data, size, to), (fd, data, size / 2, to))
WRITE(pwrite64, (int fd, const void *data, size_t size, off64_t to), (fd, data, size, to), (fd, data, size / 2, to))
CALL(read, ssize_t, (int fd, void *data, size_t size), (fd, data, size), is_ours(fd), READS)
CALL(pread, ssize_t, (int fd, void *data, size_t size, off_t from), (fd, data, size, from), is_ours(fd), READS)
CALL(pread64, ssize_t, (int fd, void *data, size_t size, off64_t from), (fd, data, size, from), is_ours(fd), READS)
CALL(fsync, int, (int fd), (fd), is_ours(fd), CHANGES)
CALL(fdatasync, int, (int fd), (fd), is_ours(fd), CHANGES)
CALL(ftruncate, int, (int fd, off_t size), (fd, size), is_ours(fd), CHANGES)
CALL(ftruncate64, int, (int fd, off64_t size), (fd, size), is_ours(fd), CHANGES)
CALL(rename, int, (const char *old, const char *new), (old, new), below(old), CHANGES)
CALL(unlink, int, (const char *path), (path), below(path), CHANGES)
CALL(mkdir, int, (const char *path, mode_t mode), (path, mode), below(path), TAKES_SPACE)
