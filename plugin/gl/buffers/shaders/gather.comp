// Positions of listed vertices, one after another.
#version 430 core
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Snapshot { uint snapshot[]; };
layout(std430, binding = 1) readonly buffer Listed { uint listed[]; };
// `finished`: the number of workgroups that have finished, from the run's number on.
layout(std430, binding = 2) buffer Gathered { uint finished, gathered[]; };
uniform uint first, count; // of the list

void main()
{
    uint i = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationID.x;
    if (i < count)
        for (uint axis = 0u; axis < 3u; axis++)
            gathered[(first + i) * 3u + axis] = snapshot[listed[first + i] * 3u + axis];
    memoryBarrierBuffer();
    barrier();
    if (gl_LocalInvocationID.x == 0u)
        atomicAdd(finished, 1u);
}
