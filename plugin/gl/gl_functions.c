// Loads a device's GL functions, and resets the state of its context. Each device has its own functions: OSMesa and EGL
// return different ones for the same name.
#include "gl/gl_functions.h"

#include "base/status.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

const char* qcGl_ErrorName(GLenum error)
{
    switch (error)
    {
        case GL_INVALID_ENUM: return "GL_INVALID_ENUM";
        case GL_INVALID_VALUE: return "GL_INVALID_VALUE";
        case GL_INVALID_OPERATION: return "GL_INVALID_OPERATION";
        case GL_INVALID_FRAMEBUFFER_OPERATION: return "GL_INVALID_FRAMEBUFFER_OPERATION";
        case GL_OUT_OF_MEMORY: return "GL_OUT_OF_MEMORY";
        case GL_CONTEXT_LOST: return "GL_CONTEXT_LOST";
        default: return "a GL error";
    }
}

qcStatus qcGl_CheckError(const struct qcGlFunctions* gl, const char* format, ...)
{
    GLenum error = gl->GetError();
    if (error == GL_NO_ERROR)
        return qc_statusOk;
    char text[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return qcFail(qc_statusDevice, "%s: %s (0x%x)", text, qcGl_ErrorName(error), error);
}

bool qcGl_HasExtension(qcGlGetFunction* getFunction, const char* name)
{
    PFNGLGETINTEGERVPROC getIntegerv = (PFNGLGETINTEGERVPROC)getFunction("glGetIntegerv");
    PFNGLGETSTRINGIPROC getStringi = (PFNGLGETSTRINGIPROC)getFunction("glGetStringi");
    GLint count = 0;
    if (getIntegerv == NULL || getStringi == NULL)
        return false;
    getIntegerv(GL_NUM_EXTENSIONS, &count);
    for (GLint i = 0; i < count; ++i)
    {
        const char* extension = (const char*)getStringi(GL_EXTENSIONS, (GLuint)i);
        if (extension != NULL && strcmp(extension, name) == 0)
            return true;
    }
    return false;
}

static void LoadProgramBinaries(struct qcGlFunctions* gl, qcGlGetFunction* getFunction)
{
    gl->GetProgramBinary = (PFNGLGETPROGRAMBINARYPROC)getFunction("glGetProgramBinary");
    gl->ProgramBinary = (PFNGLPROGRAMBINARYPROC)getFunction("glProgramBinary");
    gl->ProgramParameteri = (PFNGLPROGRAMPARAMETERIPROC)getFunction("glProgramParameteri");
}

static void LoadMemoryObjects(struct qcGlFunctions* gl, qcGlGetFunction* getFunction)
{
    if (!qcGl_HasExtension(getFunction, "GL_EXT_memory_object") ||
        !qcGl_HasExtension(getFunction, "GL_EXT_memory_object_fd"))
        return;
    gl->CreateMemoryObjects = (PFNGLCREATEMEMORYOBJECTSEXTPROC)getFunction("glCreateMemoryObjectsEXT");
    gl->DeleteMemoryObjects = (PFNGLDELETEMEMORYOBJECTSEXTPROC)getFunction("glDeleteMemoryObjectsEXT");
    gl->MemoryObjectParameteriv = (PFNGLMEMORYOBJECTPARAMETERIVEXTPROC)getFunction("glMemoryObjectParameterivEXT");
    gl->ImportMemoryFd = (PFNGLIMPORTMEMORYFDEXTPROC)getFunction("glImportMemoryFdEXT");
    gl->BufferStorageMem = (PFNGLBUFFERSTORAGEMEMEXTPROC)getFunction("glBufferStorageMemEXT");
}

qcStatus qcGlFunctions_Load(struct qcGlFunctions* gl, qcGlGetFunction* getFunction)
{
#define QC_GL_LOAD(Type, Name)                                                                                         \
    gl->Name = (Type)getFunction("gl" #Name);                                                                          \
    if (gl->Name == NULL)                                                                                              \
        return qcFail(qc_statusDevice, "the GL function gl" #Name " is missing");
    QC_GL_FUNCTIONS(QC_GL_LOAD)
#undef QC_GL_LOAD

    GLint major = 0, minor = 0;
    gl->GetIntegerv(GL_MAJOR_VERSION, &major);
    gl->GetIntegerv(GL_MINOR_VERSION, &minor);
    // The version decides: EGL returns stubs for names that it doesn't support.
    if (major * 10 + minor >= 45)
        gl->GetGraphicsResetStatus = (PFNGLGETGRAPHICSRESETSTATUSPROC)getFunction("glGetGraphicsResetStatus");
    else if (qcGl_HasExtension(getFunction, "GL_ARB_robustness"))
        gl->GetGraphicsResetStatus = (PFNGLGETGRAPHICSRESETSTATUSPROC)getFunction("glGetGraphicsResetStatusARB");
    if (major * 10 + minor >= 43)
    {
        gl->ClearBufferData = (PFNGLCLEARBUFFERDATAPROC)getFunction("glClearBufferData");
        gl->DispatchCompute = (PFNGLDISPATCHCOMPUTEPROC)getFunction("glDispatchCompute");
        gl->MemoryBarrier = (PFNGLMEMORYBARRIERPROC)getFunction("glMemoryBarrier");
    }
    if (major * 10 + minor >= 44 || qcGl_HasExtension(getFunction, "GL_ARB_buffer_storage"))
        gl->BufferStorage = (PFNGLBUFFERSTORAGEPROC)getFunction("glBufferStorage");
    if (major * 10 + minor >= 41 || qcGl_HasExtension(getFunction, "GL_ARB_get_program_binary"))
        LoadProgramBinaries(gl, getFunction);
    LoadMemoryObjects(gl, getFunction);
    return qc_statusOk;
}

void qcGlFunctions_ResetState(const struct qcGlFunctions* gl)
{
    bool keep = gl->state->keepBindings;
    gl->state->keepBindings = false;
    if (keep)
        return;
    gl->state->bound = NULL;
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    gl->BindRenderbuffer(GL_RENDERBUFFER, 0);
    gl->BindVertexArray(0);
    gl->BindBuffer(GL_ARRAY_BUFFER, 0);
    gl->UseProgram(0);
    gl->ActiveTexture(GL_TEXTURE0);
    gl->BindTexture(GL_TEXTURE_2D, 0);
    gl->Disable(GL_DEPTH_TEST);
    gl->DepthMask(GL_TRUE);
    gl->DepthFunc(GL_LESS);
    gl->Disable(GL_DEPTH_CLAMP);
    gl->DepthRange(0.0, 1.0);
    gl->Disable(GL_FRAMEBUFFER_SRGB);
    gl->Disable(GL_POLYGON_OFFSET_FILL);
    gl->PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    gl->FrontFace(GL_CCW);
    gl->PixelStorei(GL_PACK_ALIGNMENT, 4);
    gl->PixelStorei(GL_PACK_ROW_LENGTH, 0);
}
