// Loads a device's GL functions and keeps its programs. Each device has its own functions: OSMesa and EGL return
// different ones for the same name.
#include "gl/gl_functions.h"

#include "base/status.h"
#include "gl/program_cache.h"

#include <assert.h>
#include <string.h>

enum
{
    qc_maxStages = 2
};

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

static const char* StageName(GLenum stage)
{
    return stage == GL_VERTEX_SHADER ? "vertex" : stage == GL_FRAGMENT_SHADER ? "fragment" : "compute";
}

static qcStatus CompileShader(const struct qcGlFunctions* gl, const char* name, const qcShaderSource* source,
                              GLuint* shader)
{
    *shader = gl->CreateShader(source->stage);
    gl->ShaderSource(*shader, source->partCount, source->parts, NULL);
    gl->CompileShader(*shader);
    GLint compiled = GL_FALSE;
    gl->GetShaderiv(*shader, GL_COMPILE_STATUS, &compiled);
    if (compiled == GL_TRUE)
        return qc_statusOk;
    char log[256] = "";
    gl->GetShaderInfoLog(*shader, sizeof log, NULL, log);
    return qcFail(qc_statusDevice, "%s: the %s shader does not compile: %s", name, StageName(source->stage), log);
}

/// Shaders that become one program.
typedef struct Recipe
{
    const char* name;
    const qcShaderSource* sources;
    int sourceCount;
    qcProgramKey key;
} Recipe;

static qcStatus LinkProgram(const struct qcGlFunctions* gl, const Recipe* recipe, const GLuint* shaders,
                            GLuint* program)
{
    *program = gl->CreateProgram();
    for (int i = 0; i < recipe->sourceCount; i++)
        gl->AttachShader(*program, shaders[i]);
    gl->BindAttribLocation(*program, 0, "position");
    gl->BindAttribLocation(*program, 1, "normal");
    qcProgramCache_Announce(gl, &recipe->key, *program);
    gl->LinkProgram(*program);
    GLint linked = GL_FALSE;
    gl->GetProgramiv(*program, GL_LINK_STATUS, &linked);
    if (linked == GL_TRUE)
        return qc_statusOk;
    char log[256] = "";
    gl->GetProgramInfoLog(*program, sizeof log, NULL, log);
    gl->DeleteProgram(*program);
    return qcFail(qc_statusDevice, "%s: the program does not link: %s", recipe->name, log);
}

/// A linked program keeps what it needs of its shaders.
static qcStatus CompileProgram(const struct qcGlFunctions* gl, const Recipe* recipe, GLuint* program)
{
    GLuint shaders[qc_maxStages] = {0};
    qcStatus status = qc_statusOk;
    for (int i = 0; i < recipe->sourceCount && status == qc_statusOk; i++)
        status = CompileShader(gl, recipe->name, &recipe->sources[i], &shaders[i]);
    if (status == qc_statusOk)
        status = LinkProgram(gl, recipe, shaders, program);
    for (int i = 0; i < recipe->sourceCount; i++)
        gl->DeleteShader(shaders[i]); // zero is ignored
    if (status == qc_statusOk)
        qcProgramCache_Store(gl, &recipe->key, *program);
    return status;
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
    bool keep = gl->programs->keepBindings;
    gl->programs->keepBindings = false;
    if (keep)
        return;
    gl->programs->bound = NULL;
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

/// The program of this name, or 0.
static GLuint FindProgram(const struct qcGlFunctions* gl, const char* name)
{
    const struct qcGlPrograms* programs = gl->programs;
    for (uint32_t i = 0; i < programs->count; ++i)
        if (strcmp(programs->items[i].name, name) == 0)
            return programs->items[i].program;
    return 0;
}

/// Makes a program and retains it.
static qcStatus MakeProgram(const struct qcGlFunctions* gl, const char* name, const qcShaderSource* sources,
                            int sourceCount, GLuint* program)
{
    struct qcGlPrograms* programs = gl->programs;
    Recipe recipe = {.name = name, .sources = sources, .sourceCount = sourceCount};
    assert(programs->count < qc_maxPrograms && sourceCount <= qc_maxStages);
    qcStatus status = qcProgramKey_Make(gl, name, sources, sourceCount, &recipe.key);
    *program = status == qc_statusOk ? qcProgramCache_Load(gl, &recipe.key) : 0;
    if (status == qc_statusOk && *program == 0)
        status = CompileProgram(gl, &recipe, program);
    qcProgramKey_Free(&recipe.key);
    if (status == qc_statusOk)
    {
        programs->items[programs->count].name = name;
        programs->items[programs->count].program = *program;
        ++programs->count;
    }
    return status;
}

qcStatus qcGlFunctions_GetProgram(const struct qcGlFunctions* gl, const char* name, const char* vertexSource,
                                  const char* fragmentSource, GLuint* program)
{
    *program = FindProgram(gl, name);
    if (*program != 0)
        return qc_statusOk;
    const qcShaderSource sources[] = {{GL_VERTEX_SHADER, &vertexSource, 1}, {GL_FRAGMENT_SHADER, &fragmentSource, 1}};
    return MakeProgram(gl, name, sources, 2, program);
}

qcStatus qcGlFunctions_GetComputeProgram(const struct qcGlFunctions* gl, const char* name, const char* const* sources,
                                         int sourceCount, GLuint* program)
{
    *program = FindProgram(gl, name);
    if (*program != 0)
        return qc_statusOk;
    const qcShaderSource source = {GL_COMPUTE_SHADER, sources, sourceCount};
    return MakeProgram(gl, name, &source, 1, program);
}
