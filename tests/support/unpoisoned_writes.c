// Linked into programs for the memory sanitizer. The test library, Check, is not built for it: the messages that Check
// writes into a file would count as uninitialised.
#include <sanitizer/msan_interface.h>
#include <stdio.h>

size_t __real_fwrite(const void* data, size_t size, size_t count, FILE* file);
size_t __wrap_fwrite(const void* data, size_t size, size_t count, FILE* file);

size_t __wrap_fwrite(const void* data, size_t size, size_t count, FILE* file)
{
    __msan_unpoison(data, size * count);
    return __real_fwrite(data, size, count, file);
}
