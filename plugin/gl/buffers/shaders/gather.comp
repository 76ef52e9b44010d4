// Positions of listed vertices, one after another.
#version 430 core
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Snapshot { uint snapshot[]; };
layout(std430, binding = 1) readonly buffer Listed { uint listed[]; };
layout(std430, binding = 2) writeonly buffer Gathered { uint gathered[]; };
uniform uint first, count; // of the list

void main()
{
    uint i = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationID.x;
    if (i >= count)
        return;
    uint v = listed[first + i];
    for (uint axis = 0u; axis < 3u; axis++)
        gathered[(first + i) * 3u + axis] = snapshot[v * 3u + axis];
}
