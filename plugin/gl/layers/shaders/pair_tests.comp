// An invocation for each pair of triangles whose boxes overlap: may they be within the query distance? First signs of
// determinants, then separating axes. These are one algorithm with kernels/relate.inl.h and separating_axis.inl.h (the
// processor also tries the line between the centres). Tests of `layers` run both with one body (QC_LAYERS_REFINE).
// Proof: plugin/docs/proofs/layers.md.
layout(std430, binding = 1) readonly buffer Vertices { vec4 inVertices[]; };
layout(std430, binding = SOURCE_BINDING) readonly buffer TrianglePairs { uvec2 inTrianglePairs[]; };
// Takes the place of the pairs of nodes, which no kernel reads any more: BUCKET_SIZE pairs a bucket.
layout(std430, binding = 5) writeonly buffer Buckets { uvec2 outBuckets[]; };

//  ---- separating axes -----------------------------------------------------------------------------------------------

// The other corners of A and all of B, relative to the first corner of A: differences of rounded coordinates. GLSL may
// multiply out what is not `precise`, and then cancels more.
precise vec3 b, c, d, e, f;
float gap;   // required distance along an axis of length 1
float error; // of a coordinate

// Whether the cross product of two vectors separates the triangles by more than the query distance. The axis need not be
// exact, but must be equal in all dot products: GLSL may evaluate an expression that is not `precise` anew for each use,
// and round it differently.
bool separates(vec3 first, vec3 second)
{
    precise vec3 axis = cross(first, second);
    float u = dot(axis, b), v = dot(axis, c), p = dot(axis, d), q = dot(axis, e), r = dot(axis, f);
    float size = abs(axis.x) + abs(axis.y) + abs(axis.z), required = size * gap;
    float above = min(p, min(q, r)) - max(0.0, max(u, v)), below = min(0.0, min(u, v)) - max(p, max(q, r));
    return max(above, below) > max(required, 1e-20);
}

void loadCorners(uint s, uint t)
{
    uvec4 i0 = texelFetch(triangles, int(s)), i1 = texelFetch(triangles, int(t));
    vec3 a = inVertices[i0.x].xyz;
    b = inVertices[i0.y].xyz - a;
    c = inVertices[i0.z].xyz - a;
    d = inVertices[i1.x].xyz - a;
    e = inVertices[i1.y].xyz - a;
    f = inVertices[i1.z].xyz - a;
    vec3 largest = max(max(max(abs(b), abs(c)), max(abs(d), abs(e))), abs(f));
    float size = max(largest.x, max(largest.y, largest.z));
    // A power of two, so that no product below underflows.
    float up = uintBitsToFloat((254u << 23) - (floatBitsToUint(size) & 0x7f800000u));
    b *= up, c *= up, d *= up, e *= up, f *= up;
    gap = (4.0 * pointError + queryDistance) * up * 1.0001 + 4e-6;
    error = 2.0 * pointError * up + 2.4e-7;
}

// Whether an axis separates the triangles by more than the query distance.
bool areApart()
{
    vec3 bc = c - b, de = e - d, df = f - d, ef = f - e;
    precise vec3 n = cross(b, c), m = cross(de, df);
    // No early exit: arithmetic costs less than branches.
    bool apart = separates(b, c);
    apart = separates(de, df) || apart;
    apart = separates(b, de) || apart;
    apart = separates(b, df) || apart;
    apart = separates(b, ef) || apart;
    apart = separates(c, de) || apart;
    apart = separates(c, df) || apart;
    apart = separates(c, ef) || apart;
    apart = separates(bc, de) || apart;
    apart = separates(bc, df) || apart;
    apart = separates(bc, ef) || apart;
    apart = separates(n, b) || apart;
    apart = separates(n, c) || apart;
    apart = separates(n, bc) || apart;
    apart = separates(m, de) || apart;
    apart = separates(m, df) || apart;
    apart = separates(m, ef) || apart;
    return apart;
}

//  ---- signs of determinants -----------------------------------------------------------------------------------------

// What is proven for a pair: that it is disjoint; that the interiors intersect.
bool areDisjoint, areIntersecting;

// The proven sign; 0: none is.
int signOf(float x, float maxError)
{
    return int(x > maxError) - int(x < -maxError);
}

// An edge against a triangle: the sides of its ends, and the sides on which its line passes the triangle's edges.
void addEdge(int p, int q, int r, int s, int t)
{
    int low = min(r, min(s, t)), high = max(r, max(s, t));
    areDisjoint = areDisjoint && (low * high < 0 || p * q > 0);
    areIntersecting = areIntersecting || (low * high > 0 && p * q < 0);
}

// kernels/relate.inl.h, with room for GLSL's rounding: twice the processor's. Proof: plugin/docs/proofs/pair_signs.md.
void decide()
{
    vec3 one = vec3(1.0);
    float sizeA = 1.001 * max(dot(abs(b), one), dot(abs(c), one)),
          sizeB = 1.001 * max(dot(abs(d), one), max(dot(abs(e), one), dot(abs(f), one)));
    float aa = error * sizeA * sizeA, ab = error * sizeA * sizeB, bb = error * sizeB * sizeB;
    float constant = 48.0 * error * error + 3.0e-5, several = 4.0 * constant + 7.2e-5;
    vec3 n = cross(b, c), mx = cross(d, e), my = cross(e, f), mz = cross(f, d);
    vec3 x = vec3(dot(b, mx), dot(b, my), dot(b, mz)), y = vec3(dot(c, mx), dot(c, my), dot(c, mz)),
         ofPlaneA = vec3(dot(n, d), dot(n, e), dot(n, f)), last = y - x + ofPlaneA.yzx - ofPlaneA;
    float volume = dot(d, my);
    float planeError = aa + 2.0 * ab + constant, sideError = bb + 2.0 * ab + constant,
          lastError = 2.0 * (aa + bb) + 8.0 * ab + several, cornerError = 6.0 * (bb + ab) + several;
    int ofA[3] = int[](signOf(-volume, 3.0 * bb + constant), signOf(x.x + x.y + x.z - volume, cornerError),
                       signOf(y.x + y.y + y.z - volume, cornerError));
    int ofB[3], side[9]; // side[3 * i + j]: on which side the line of edge i of A passes edge j of B
    for (int j = 0; j < 3; j++)
    {
        ofB[j] = signOf(ofPlaneA[j], planeError);
        side[j] = signOf(x[j], sideError);
        side[3 + j] = signOf(last[j], lastError);
        side[6 + j] = signOf(-y[j], sideError);
    }
    areDisjoint = true, areIntersecting = false;
    for (int i = 0; i < 3; i++)
    {
        int next = i < 2 ? i + 1 : 0;
        addEdge(ofA[i], ofA[next], side[3 * i], side[3 * i + 1], side[3 * i + 2]);
        addEdge(ofB[i], ofB[next], side[i], side[3 + i], side[6 + i]);
    }
}

// Whether the triangles at two slots may be within the query distance; areIntersecting: they surely intersect.
bool mayMeet(uint s, uint t)
{
    loadCorners(s, t);
    decide();
    bool apart = areDisjoint && queryDistance == 0.0;
    return areIntersecting || (!apart && !areApart());
}

//  ---- results -----------------------------------------------------------------------------------------------------------

// The step's number of the triangle at a slot.
uint numberOf(uint slot)
{
    return bodyWord(texelFetch(nodes, int(slot >> 6)).x, 20u) + texelFetch(triangles, int(slot)).w;
}

shared uint keptCount, firstKept;

// A pair as qcRelatedPair_Make makes it, lower word first. Disjoint: this is not known.
uvec2 relatedPair(uvec2 slots)
{
    uint s = numberOf(slots.x), t = numberOf(slots.y), first = min(s, t), second = max(s, t);
    return uvec2(second << 2 | (areIntersecting ? PENETRATING : 0u), first << 1 | second >> 30);
}

// Puts a pair into the bucket of its first triangle. False: that is full.
bool addToBucket(uvec2 pair)
{
    uint bucket = pair.y >> bucketShift + 1u, place = atomicAdd(counters[bucketsAt + bucket], 1u);
    if (place < BUCKET_SIZE)
        outBuckets[bucket * BUCKET_SIZE + place] = pair;
    return place < BUCKET_SIZE;
}

// One append for all of the workgroup's pairs that are kept.
void testPairs(uint first, uint count, uint k)
{
    if (k == 0u)
        keptCount = 0u;
    barrier();
    uvec2 pair = inTrianglePairs[first + min(k, count - 1u)];
    bool isKept = k < count && mayMeet(pair.x, pair.y);
    uint place = isKept ? atomicAdd(keptCount, 1u) : 0u;
    barrier();
    if (k == 0u && keptCount != 0u)
        firstKept = append(survivorCounter, keptCount);
    barrier();
    if (isKept)
    {
        uvec2 related = relatedPair(pair);
        bool isInBucket = bucketCount != 0u && addToBucket(related);
        if (!isInBucket)
        {
            uint at = bucketCount != 0u ? atomicAdd(counters[unorderedCounter], 1u) : firstKept + place;
            outResults[resultsAt + min(at, survivorCapacity)] = related;
        }
    }
    barrier();
}

void main()
{
    uint k = gl_LocalInvocationID.x, groups = gl_NumWorkGroups.x * gl_NumWorkGroups.y, first = GROUP * LOCAL_SIZE;
    // With too small a list the kernels run again.
    uint listed = counters[trianglePairCounter], count = listed <= trianglePairCapacity ? listed : 0u;
    for (; first < count; first += groups * LOCAL_SIZE)
        testPairs(first, min(count - first, LOCAL_SIZE), k);
    if (first < count)
        atomicMax(counters[stoppedCounter], 1u);
    if (bucketCount != 0u)
        countKernel(pairTestsRan);
    else
        finish(groups, k, nodesRan | nodePairsRan | trianglePairsRan);
}
