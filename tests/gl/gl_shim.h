// What libraries in front of the system's GL libraries share. QC_GL_SHIM names how they differ: see
// test_gl_libraries.c.
#ifndef QC_TESTS_GL_SHIM_H
#define QC_TESTS_GL_SHIM_H

#include <dlfcn.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define SHIM __attribute__((visibility("default")))

/// Whether the shim behaves so now.
static bool Is(const char* behaviour)
{
    const char* set = getenv("QC_GL_SHIM");
    return set != NULL && strcmp(set, behaviour) == 0;
}

/// A function of the system's library, the only one of its process that this shim opens. Null: there is none.
static void* Real(const char* path, const char* name)
{
    static void* library;
    if (library == NULL)
        library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    return library != NULL ? dlsym(library, name) : NULL;
}

#endif
