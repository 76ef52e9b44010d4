// Shared code of the kernels that find sure results; gl/visibility/sure_results.c does the same on the processor. Proof:
// plugin/docs/proofs/sure_results.md.
layout(local_size_x = 64) in;

// qcSureParameters of gl/visibility/sure_kernels.c.
layout(std140, binding = 0) uniform Parameters
{
    uint partCount, axis, cellsPerSide, entryCapacity;
    float resolution, cellsPerPixel, direction; // -1: depths grow towards the eye
    uint runNumber;
};

const uint usesTest = 1u, usesRender = 2u;

// A triangle in pixels; depths grow away from the eye.
struct Triangle
{
    vec4 x;     // of the corners; w: nearest depth, error included
    vec4 y;     // of the corners; w: farthest depth
    vec4 z;     // of the corners; w: the error of a drawn depth
    vec4 box;   // lower and upper, larger by the snap
    vec4 plane; // slopes; z: 1: counter-clockwise, -1: clockwise, 0: rounding may decide
};

// A render in a cell, with what most comparisons need.
struct Entry
{
    vec4 box;
    float nearest;
    uint part, step, unused;
};

// The triangles of the steps: triangle, then 4 times the step plus the uses.
layout(std430, binding = 1) readonly buffer Parts { uvec2 parts[]; };
layout(std430, binding = 2) buffer Triangles { Triangle triangles[]; };
// By cell: the number of its entries, then the end of those written; and behind them, by cell, its first entry.
layout(std430, binding = 3) buffer Cells { uint cells[]; };
layout(std430, binding = 4) buffer Entries { Entry entries[]; };
// The number of entries, whether a loop was stopped, the number of the last run that has come to the tests, then for each
// part what is drawn of it, or that it is hidden.
layout(std430, binding = 5) buffer Results { uint results[]; };
const uint entryCounter = 0u, stopCounter = 1u, runCounter = 2u, firstResult = 3u;
const uint isHiddenPart = 4u;

// Pixels by which a rasteriser may move a corner, in x and y each: GL demands 4 bits of subpixel.
const float snap = 0.0625;

uint itemOf()
{
    return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
}

bool isRendered(uint part)
{
    return (parts[part].y & usesRender) != 0u;
}

uint findCell(float pixel)
{
    float cell = pixel * cellsPerPixel;
    return cell > 0.0 ? min(uint(min(cell, 65536.0)), cellsPerSide - 1u) : 0u;
}

// First and last cell, in x and y each.
uvec4 findCells(vec4 box)
{
    return uvec4(findCell(box.x), findCell(box.y), findCell(box.z), findCell(box.w));
}

// Whether a box contains the centre of a pixel. Without one, a triangle has no fragment.
bool hasSample(vec4 box)
{
    return all(greaterThanEqual(floor(box.zw - 0.5), ceil(box.xy - 0.5)));
}

// Twice the signed area of two edges, and the error of that by snapping and rounding.
float cross2(vec2 e, vec2 w, out float error)
{
    error = 2.0 * snap * (abs(e.x) + abs(e.y) + abs(w.x) + abs(w.y)) + 8.0 * snap * snap;
    return e.x * w.y - e.y * w.x;
}
