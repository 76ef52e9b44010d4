// Copies positions from a buffer of the host's, checks that they are finite, and finds their bounds. All arithmetic is on
// the floats' bits, so that no denormal is lost and no NaN is changed.
#version 430 core
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Source { uint source[]; };
layout(std430, binding = 1) writeonly buffer Snapshot { uint snapshot[]; };
// Three lower ends, complements of three upper ends, as ordered integers; the first vertex that is not finite: all ones at
// first. The number of workgroups that have finished, from the run's number on.
layout(std430, binding = 2) buffer Bounds { uint bounds[8]; };
layout(std430, binding = 3) readonly buffer Used { uint used[]; }; // a bit a vertex
uniform uint vertexCount, first, stride; // words
uniform uint skipsUnused;                // 1: the bounds are those of vertices with a bit in `used`

const uint perInvocation = 16u, exponent = 0x7f800000u;
shared uint parts[6][64];

// Integers in the order of the floats.
uint ordered(uint bits)
{
    return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}

void main()
{
    uint at[6] = uint[6](~0u, ~0u, ~0u, ~0u, ~0u, ~0u);
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    for (uint i = 0u; i < perInvocation; i++)
    {
        uint v = (group * perInvocation + i) * 64u + gl_LocalInvocationID.x;
        if (v >= vertexCount)
            break;
        bool counts = skipsUnused == 0u || (used[v >> 5] >> (v & 31u) & 1u) != 0u, finite = true;
        for (int axis = 0; axis < 3; axis++)
        {
            uint bits = source[first + v * stride + uint(axis)];
            snapshot[v * 3u + uint(axis)] = bits;
            finite = finite && (bits & exponent) != exponent;
            if (counts)
            {
                at[axis] = min(at[axis], ordered(bits));
                at[3 + axis] = min(at[3 + axis], ~ordered(bits));
            }
        }
        if (!finite)
            atomicMin(bounds[6], v);
    }
    for (int i = 0; i < 6; i++)
        parts[i][gl_LocalInvocationID.x] = at[i];
    for (uint span = 32u; span != 0u; span >>= 1)
    {
        barrier();
        if (gl_LocalInvocationID.x < span)
            for (int i = 0; i < 6; i++)
                parts[i][gl_LocalInvocationID.x] =
                    min(parts[i][gl_LocalInvocationID.x], parts[i][gl_LocalInvocationID.x + span]);
    }
    if (gl_LocalInvocationID.x == 0u)
        for (int i = 0; i < 6; i++)
            atomicMin(bounds[i], parts[i][0]);
    memoryBarrierBuffer();
    barrier();
    if (gl_LocalInvocationID.x == 0u)
        atomicAdd(bounds[7], 1u);
}
