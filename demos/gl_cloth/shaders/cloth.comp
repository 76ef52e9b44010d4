// A cloth on the GPU, one kernel a value of KERNEL: Verlet steps, distance constraints by Jacobi iterations (Mueller et
// al.: Position Based Dynamics, 2007) with a ball and the ground, and the response to pairs of triangles.
layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Positions { float positions[]; }; // three a vertex
layout(std430, binding = 1) buffer Previous { float previous[]; };   // one time step earlier
layout(std430, binding = 2) buffer Next { float next[]; };           // of an iteration
layout(std430, binding = 3) buffer Safe { float safe[]; };           // of the last frame
layout(std430, binding = 4) buffer Pushes { int pushes[]; };         // sums, in units of 1 / pushUnits
struct Pair { uint bodyA, triangleA, bodyB, triangleB, relation; };
layout(std430, binding = 5) readonly buffer Pairs { uint pairCount; Pair pairs[]; };
layout(std430, binding = 6) readonly buffer Indices { uint indices[]; };
uniform uint side;  // vertices on a side
uniform float time;

const float size = 2.0, timeStep = 1.0 / 480.0, ballRadius = 0.45, skin = 0.01, pushUnits = 1048576.0;
const vec3 ball = vec3(0.0, 0.7, 0.0);
uint item = gl_WorkGroupID.x * 64u + gl_LocalInvocationID.x;

#define READ(buffer, v) vec3(buffer[(v) * 3u], buffer[(v) * 3u + 1u], buffer[(v) * 3u + 2u])
#define WRITE(buffer, v, p) (buffer[(v) * 3u] = (p).x, buffer[(v) * 3u + 1u] = (p).y, buffer[(v) * 3u + 2u] = (p).z)

#if KERNEL == 0 // moves by inertia, gravity and wind
void work(uint v)
{
    vec3 p = READ(positions, v);
    vec3 wind = vec3(2.5 * sin(1.7 * time), 0.0, 1.5 * sin(2.9 * time + 4.0 * p.x));
    vec3 moved = p + 0.998 * (p - READ(previous, v)) + (vec3(0.0, -9.8, 0.0) + wind) * timeStep * timeStep;
    WRITE(previous, v, p);
    WRITE(positions, v, moved);
}
#elif KERNEL == 1 // an iteration, from positions to next
void work(uint v)
{
    ivec2 at = ivec2(v % side, v / side);
    vec3 p = READ(positions, v), sum = vec3(0.0);
    float count = 0.0;
    for (int y = -2; y <= 2; y++)
        for (int x = -2; x <= 2; x++)
        {
            ivec2 other = at + ivec2(x, y);
            bool linked = (x != 0 || y != 0) && (abs(x) < 2 && abs(y) < 2 || x == 0 || y == 0);
            if (!linked || any(lessThan(other, ivec2(0))) || any(greaterThanEqual(other, ivec2(side))))
                continue;
            vec3 d = READ(positions, uint(other.y) * side + uint(other.x)) - p;
            float rest = length(vec2(x, y)) * size / float(side - 1u), distance = max(length(d), 1e-9);
            sum += 0.5 * (distance - rest) / distance * d;
            count += 1.0;
        }
    p += 1.6 * sum / count;
    vec3 d = p - ball;
    if (length(d) < ballRadius + skin)
    {
        p = ball + normalize(d) * (ballRadius + skin);
        WRITE(previous, v, mix(READ(previous, v), p, 0.2)); // friction
    }
    p.y = max(p.y, 0.002);
    WRITE(next, v, p);
}
#elif KERNEL == 2 // each pair pushes its triangles to the sides on which they were
void work(uint i)
{
    uvec3 a = uvec3(indices[pairs[i].triangleA * 3u], indices[pairs[i].triangleA * 3u + 1u],
                    indices[pairs[i].triangleA * 3u + 2u]);
    uvec3 b = uvec3(indices[pairs[i].triangleB * 3u], indices[pairs[i].triangleB * 3u + 1u],
                    indices[pairs[i].triangleB * 3u + 2u]);
    vec3 d = READ(safe, a.x) + READ(safe, a.y) + READ(safe, a.z) - READ(safe, b.x) - READ(safe, b.y) - READ(safe, b.z);
    ivec3 push = ivec3(0.1 * size / float(side - 1u) * pushUnits * d / max(length(d), 1e-9));
    for (int c = 0; c < 3; c++)
        for (int axis = 0; axis < 3; axis++)
        {
            atomicAdd(pushes[a[c] * 4u + uint(axis)], push[axis]);
            atomicAdd(pushes[b[c] * 4u + uint(axis)], -push[axis]);
        }
    for (int c = 0; c < 3; c++)
    {
        atomicAdd(pushes[a[c] * 4u + 3u], 1);
        atomicAdd(pushes[b[c] * 4u + 3u], 1);
    }
}
#else // applies the mean push, and stops what was pushed
void work(uint v)
{
    vec3 p = READ(positions, v);
    int count = pushes[v * 4u + 3u];
    if (count > 0)
    {
        p += vec3(pushes[v * 4u], pushes[v * 4u + 1u], pushes[v * 4u + 2u]) / (pushUnits * float(count));
        WRITE(positions, v, p);
        WRITE(previous, v, p);
    }
    for (uint i = 0u; i < 4u; i++)
        pushes[v * 4u + i] = 0;
    WRITE(safe, v, p);
}
#endif

void main()
{
#if KERNEL == 2
    for (; item < pairCount; item += gl_NumWorkGroups.x * 64u)
        work(item);
#else
    if (item < side * side)
        work(item);
#endif
}
