/* What compilers expect of a C library, as the kernel is linked with none. */
#include <stddef.h>

__attribute__((no_builtin)) void *memcpy(void *restrict to, const void *restrict from, size_t count) {
    for (size_t k = 0; k < count; k++) ((unsigned char *)to)[k] = ((const unsigned char *)from)[k];
    return to;
}

__attribute__((no_builtin)) void *memset(void *to, int value, size_t count) {
    for (size_t k = 0; k < count; k++) ((unsigned char *)to)[k] = (unsigned char)value;
    return to;
}

#if defined(_WIN32)
/* Windows calls this where a library is loaded; there is nothing to begin. */
__declspec(dllexport) int __stdcall DllMainCRTStartup(void *library, unsigned reason, void *reserved) {
    (void)library, (void)reason, (void)reserved;
    return 1;
}
#endif
