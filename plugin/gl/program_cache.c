// Keys are compared as a whole: no hash stands for a source or a driver.
#include "gl/program_cache.h"

#include "base/status.h"
#include "gl/cache_files.h"
#include "gl/programs.h"

#include <stdio.h>
#include <string.h>

enum
{
    qc_maxFormats = 16
};

static void DropErrors(const struct qcGlFunctions* gl)
{
    // Bounded: a lost context has an error for each call.
    for (int i = 0; i < 8 && gl->GetError() != GL_NO_ERROR; i++)
        continue;
}

/// Reads the driver's formats of binaries; 0: it has none, or more than there is room for.
static int ReadFormats(const struct qcGlFunctions* gl, GLint formats[qc_maxFormats])
{
    GLint count = 0;
    if (gl->ProgramBinary == NULL)
        return 0;
    gl->GetIntegerv(GL_NUM_PROGRAM_BINARY_FORMATS, &count);
    if (count <= 0 || count > qc_maxFormats)
        return 0;
    gl->GetIntegerv(GL_PROGRAM_BINARY_FORMATS, formats);
    return (int)count;
}

static bool HasFormat(const struct qcGlFunctions* gl, GLenum format)
{
    GLint formats[qc_maxFormats] = {0};
    int count = ReadFormats(gl, formats);
    for (int i = 0; i < count; i++)
        if ((GLenum)formats[i] == format)
            return true;
    return false;
}

/// Adds a text and its final 0. False: out of memory.
static bool AddText(qcArray* key, const char* text)
{
    const size_t at = key->count, size = text != NULL ? strlen(text) + 1 : 1;
    if (qcArray_Resize(key, at + size, 1, "a program's key") != qc_statusOk)
        return false;
    memcpy((char*)key->data + at, text != NULL ? text : "", size);
    return true;
}

static bool AddNumber(qcArray* key, unsigned long number)
{
    char text[32];
    snprintf(text, sizeof text, "%lx", number);
    return AddText(key, text);
}

static bool AddDriver(const struct qcGlFunctions* gl, qcArray* key)
{
    static const GLenum s_names[] = {GL_VENDOR, GL_RENDERER, GL_VERSION, GL_SHADING_LANGUAGE_VERSION};
    GLint formats[qc_maxFormats] = {0};
    const int count = ReadFormats(gl, formats);
    bool added = count != 0 && AddText(key, gl->programs->opener);
    for (size_t i = 0; i < sizeof s_names / sizeof s_names[0] && added; i++)
        added = AddText(key, (const char*)gl->GetString(s_names[i]));
    for (int i = 0; i < count && added; i++)
        added = AddNumber(key, (unsigned long)formats[i]);
    return added;
}

static bool AddSources(const char* name, const qcShaderSource* sources, int sourceCount, qcArray* key)
{
    // Attributes are bound by the library's code, which the version stands for.
    bool added = AddNumber(key, QC_VERSION) && AddText(key, name);
    for (int i = 0; i < sourceCount && added; i++)
    {
        added = AddNumber(key, sources[i].stage);
        for (int part = 0; part < sources[i].partCount && added; part++)
            added = AddText(key, sources[i].parts[part]);
    }
    return added;
}

qcStatus qcProgramKey_Make(const struct qcGlFunctions* gl, const char* name, const qcShaderSource* sources,
                           int sourceCount, qcProgramKey* key)
{
    *key = (qcProgramKey){.folder = NULL};
    if (gl->programs->cacheFolder == NULL || gl->programs->cacheFolder[0] == 0)
        return qc_statusOk;
    // Errors of the cache are dropped; those of earlier calls must not be.
    QC_TRY(qcGl_CheckError(gl, "before the program %s", name));
    if (AddDriver(gl, &key->text) && AddSources(name, sources, sourceCount, &key->text))
        key->folder = gl->programs->cacheFolder;
    DropErrors(gl);
    return qc_statusOk;
}

void qcProgramKey_Free(qcProgramKey* key)
{
    qcArray_Free(&key->text);
    key->folder = NULL;
}

static qcBytes TextOf(const qcProgramKey* key)
{
    return (qcBytes){key->text.data, key->text.count};
}

/// A program of a binary; 0: the driver refuses it.
static GLuint MakeProgram(const struct qcGlFunctions* gl, const qcCacheValue* value)
{
    if (!HasFormat(gl, value->tag))
        return 0;
    GLint linked = GL_FALSE;
    GLuint program = gl->CreateProgram();
    gl->ProgramBinary(program, value->tag, value->bytes.data, (GLsizei)value->bytes.size);
    if (gl->GetError() == GL_NO_ERROR)
        gl->GetProgramiv(program, GL_LINK_STATUS, &linked);
    if (linked == GL_TRUE)
        return program;
    gl->DeleteProgram(program);
    DropErrors(gl);
    return 0;
}

GLuint qcProgramCache_Load(const struct qcGlFunctions* gl, const qcProgramKey* key)
{
    qcArray file = {NULL, 0, 0};
    qcCacheValue value;
    GLuint program = 0;
    if (key->folder != NULL && qcCacheFiles_Read(key->folder, TextOf(key), &file, &value))
        program = MakeProgram(gl, &value);
    qcArray_Free(&file);
    return program;
}

void qcProgramCache_Announce(const struct qcGlFunctions* gl, const qcProgramKey* key, GLuint program)
{
    if (key->folder != NULL)
        gl->ProgramParameteri(program, GL_PROGRAM_BINARY_RETRIEVABLE_HINT, GL_TRUE);
}

void qcProgramCache_Store(const struct qcGlFunctions* gl, const qcProgramKey* key, GLuint program)
{
    GLint size = 0;
    GLsizei length = 0;
    GLenum format = 0;
    if (key->folder == NULL)
        return;
    gl->GetProgramiv(program, GL_PROGRAM_BINARY_LENGTH, &size);
    char* binary = size > 0 ? qcAllocate((size_t)size) : NULL;
    if (binary == NULL)
        return;
    gl->GetProgramBinary(program, size, &length, &format, binary);
    if (gl->GetError() == GL_NO_ERROR && length > 0 && length <= size)
        qcCacheFiles_Write(key->folder, TextOf(key), &(qcCacheValue){format, {binary, (size_t)length}});
    DropErrors(gl);
    qcFree(binary, (size_t)size);
}
