// Uploads the parts of a pass, runs the kernels of gl/visibility/shaders, reads the results.
#include "gl/visibility/sure_kernels.h"

#include "base/status.h"
#include "gl/compute.h"
#include "gl/programs.h"
#include "visibility_shaders.h"

#include <math.h>
#include <string.h>

enum
{
    qc_localSize = 64,
    qc_lanes = 8, // invocations for a triangle in the last kernel
    // Steps are numbered in 30 bits.
    qc_maxSteps = 1 << 30,
    qc_maxCellsPerSide = 1024,
    // Parts that are sampled: their size decides that of the cells.
    qc_maxSampledParts = 1000,
    // Places for the renders of cells, per part. A triangle as large as a cell touches four on average.
    qc_entriesPerPart = 8,
    qc_counterCount = 3
};

typedef enum Kernel
{
    qc_kernelTriangles,
    qc_kernelCells,
    qc_kernelEntries,
    qc_kernelTests
} Kernel;

/// Buffers other than the corners, at the bindings that the shaders have; the first is a uniform block's.
typedef enum Buffer
{
    qc_bufferParameters,
    qc_bufferParts,
    qc_bufferTriangles,
    qc_bufferCells,
    qc_bufferEntries,
    qc_bufferResults
} Buffer;

/// The uniform block of the kernels, in the layout std140.
typedef struct Parameters
{
    uint32_t partCount, axis, cellsPerSide, entryCapacity;
    float resolution, cellsPerPixel, direction;
    uint32_t runNumber;
} Parameters;

/// A triangle of a step, as the shaders have it.
typedef struct Part
{
    uint32_t triangle, stepAndUses;
} Part;

enum
{
    // Sizes that the shaders have in std430.
    qc_triangleBytes = 80,
    qc_entryBytes = 32
};

bool qcSureKernels_AreSupported(const struct qcGlFunctions* gl)
{
    return gl->DispatchCompute != NULL;
}

qcStatus qcSureKernels_Create(const struct qcGlFunctions* gl, qcSureKernels* kernels)
{
    static const struct
    {
        const char *name, *source;
    } s_kernels[qc_sureKernelCount] = {
        [qc_kernelTriangles] = {"sure visibility, triangles", s_visibilityTriangles},
        [qc_kernelCells] = {"sure visibility, cells", s_visibilityCells},
        [qc_kernelEntries] = {"sure visibility, entries", s_visibilityEntries},
        [qc_kernelTests] = {"sure visibility, tests", s_visibilityTests},
    };
    for (int i = 0; i < qc_sureKernelCount; ++i)
    {
        const char* sources[] = {"#version 430 core\n", s_visibilityCommon, s_kernels[i].source};
        QC_TRY(qcGlPrograms_GetCompute(gl, s_kernels[i].name, sources, 3, &kernels->programs[i]));
    }
    gl->GenBuffers(qc_sureBufferCount, kernels->buffers);
    kernels->maxBytes = (size_t)qcGl_MaxStorageBytes(gl);
    return qc_statusOk;
}

void qcSureKernels_Delete(const struct qcGlFunctions* gl, const qcSureKernels* kernels)
{
    gl->DeleteBuffers(qc_sureBufferCount, kernels->buffers);
}

void qcSureKernels_Free(qcSureKernels* kernels)
{
    qcArray_Free(&kernels->parts);
    qcArray_Free(&kernels->found);
}

static qcStatus ListParts(qcSureKernels* kernels, const qcVisibilityStep* steps, uint32_t stepCount)
{
    QC_TRY(qcArray_Reserve(&kernels->parts, qcSureResults_CountTriangles(steps, stepCount), sizeof(Part),
                           "parts of visibility tests"));
    Part* part = kernels->parts.data;
    for (uint32_t s = 0; s < stepCount; ++s)
    {
        uint32_t uses = (steps[s].test ? qc_sureTest : 0u) | (steps[s].render ? qc_sureRender : 0u);
        for (uint32_t k = 0; k < qcSureResults_CountParts(&steps[s]); ++k)
            *part++ = (Part){steps[s].firstTriangle + k, s << 2 | uses};
    }
    kernels->parts.count = (size_t)(part - (Part*)kernels->parts.data);
    return qc_statusOk;
}

/// Half the perimeter of a triangle's box over two, in the image.
static float FindSize(const qcSureView* view, uint32_t triangle)
{
    const float* corner = view->corners + (size_t)9 * triangle;
    float size = 0.0f;
    for (int i = 1; i <= 2; ++i)
    {
        const float* x = corner + (view->axis + i) % 3;
        size += fmaxf(x[0], fmaxf(x[3], x[6])) - fminf(x[0], fminf(x[3], x[6]));
    }
    return 0.5f * size;
}

/// Cells about as large as the mean box, at most four a triangle.
static uint32_t ChooseCells(const qcSureKernels* kernels, const qcSureView* view)
{
    size_t count = kernels->parts.count, stride = 1 + count / qc_maxSampledParts, sampled = 0;
    double sum = 0.0;
    for (size_t i = 0; i < count; i += stride, ++sampled)
        sum += FindSize(view, QC_AT(Part, kernels->parts, i).triangle);
    double cells = fmin(2.0 * (double)sampled / fmax(sum, 1e-9), 2.0 * sqrt((double)count));
    return cells < 1.0 ? 1 : cells < qc_maxCellsPerSide ? (uint32_t)cells : qc_maxCellsPerSide;
}

/// Binds a buffer of at least this size. Its contents are undefined where it grows.
static void BindBuffer(const struct qcGlFunctions* gl, qcSureKernels* kernels, Buffer buffer, size_t bytes)
{
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, buffer, kernels->buffers[buffer]);
    if (kernels->bytes[buffer] >= bytes)
        return;
    // Clearing needs whole words.
    kernels->bytes[buffer] = (bytes + bytes / 4 + 63) / 64 * 64;
    gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)kernels->bytes[buffer], NULL, GL_DYNAMIC_COPY);
}

/// Uploads what the kernels read and clears the cells.
static void Upload(const struct qcGlFunctions* gl, qcSureKernels* kernels, const Parameters* parameters, GLuint corners)
{
    size_t partCount = parameters->partCount, cellCount = (size_t)parameters->cellsPerSide * parameters->cellsPerSide;
    gl->BindBufferBase(GL_UNIFORM_BUFFER, 0, kernels->buffers[qc_bufferParameters]);
    gl->BufferData(GL_UNIFORM_BUFFER, sizeof *parameters, parameters, GL_STREAM_DRAW);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, corners);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, qc_bufferParts, kernels->buffers[qc_bufferParts]);
    gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)(partCount * sizeof(Part)), kernels->parts.data,
                   GL_STREAM_DRAW);
    BindBuffer(gl, kernels, qc_bufferTriangles, partCount * qc_triangleBytes);
    BindBuffer(gl, kernels, qc_bufferEntries, (size_t)parameters->entryCapacity * qc_entryBytes);
    BindBuffer(gl, kernels, qc_bufferResults, (partCount + qc_counterCount) * sizeof(uint32_t));
    BindBuffer(gl, kernels, qc_bufferCells, 2 * cellCount * sizeof(uint32_t));
    const uint32_t zero = 0;
    gl->ClearBufferData(GL_SHADER_STORAGE_BUFFER, GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, &zero);
}

static void Run(const struct qcGlFunctions* gl, const qcSureKernels* kernels, Kernel kernel, size_t items)
{
    gl->UseProgram(kernels->programs[kernel]);
    gl->MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    qcGl_Dispatch(gl, (items + qc_localSize - 1) / qc_localSize);
}

qcStatus qcSureKernels_Find(const struct qcGlFunctions* gl, qcSureKernels* kernels, const qcSureView* view,
                            GLuint corners, const qcVisibilityStep* steps, uint32_t stepCount, const uint32_t** found)
{
    *found = NULL;
    QC_TRY(ListParts(kernels, steps, stepCount));
    size_t count = kernels->parts.count;
    size_t entryCapacity = qc_entriesPerPart * count;
    if (count == 0 || stepCount > qc_maxSteps || qc_triangleBytes * count > kernels->maxBytes)
        return qc_statusOk;
    if (entryCapacity > kernels->maxBytes / qc_entryBytes)
        entryCapacity = kernels->maxBytes / qc_entryBytes;
    Parameters parameters = {.partCount = (uint32_t)count,
                             .axis = (uint32_t)view->axis,
                             .cellsPerSide = ChooseCells(kernels, view),
                             .entryCapacity = (uint32_t)entryCapacity,
                             .resolution = (float)view->resolution,
                             .direction = view->fromBack ? -1.0f : 1.0f,
                             .runNumber = ++kernels->runNumber};
    parameters.cellsPerPixel = (float)parameters.cellsPerSide / (float)view->resolution;
    QC_TRY(qcArray_Resize(&kernels->found, count + qc_counterCount, sizeof(uint32_t), "results of visibility tests"));
    Upload(gl, kernels, &parameters, corners);
    Run(gl, kernels, qc_kernelTriangles, count);
    Run(gl, kernels, qc_kernelCells, (size_t)parameters.cellsPerSide * parameters.cellsPerSide);
    Run(gl, kernels, qc_kernelEntries, count);
    Run(gl, kernels, qc_kernelTests, qc_lanes * count);
    uint32_t* results = kernels->found.data;
    // A buffer that can't be read leaves this value.
    results[2] = ~parameters.runNumber;
    gl->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, kernels->buffers[qc_bufferResults]);
    gl->GetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, (GLsizeiptr)((count + qc_counterCount) * sizeof(uint32_t)),
                         results);
    // A context that is lost, and can't say so, runs nothing.
    if (results[2] != parameters.runNumber)
        return qcFail(qc_statusDevice, "visibility: the device hasn't run the kernels");
    if (results[0] <= parameters.entryCapacity && results[1] == 0)
        *found = results + qc_counterCount;
    return qc_statusOk;
}
