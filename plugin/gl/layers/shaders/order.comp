// A workgroup for each bucket orders its pairs of triangles, and writes them behind those of the buckets before it.
layout(std430, binding = 5) readonly buffer Buckets { uvec2 inBuckets[]; };

shared uvec2 pairs[BUCKET_SIZE], inOrder[BUCKET_SIZE];
shared uint before; // pairs in the buckets before this one

// Full buckets count the pairs for which they had no room, too.
uint countOf(uint bucket)
{
    return min(counters[bucketsAt + bucket], BUCKET_SIZE);
}

// The number of pairs that come before pair i. Equal ones keep their order, so that no two have one place.
uint rankOf(uint i, uint count)
{
    uvec2 pair = pairs[i];
    uint rank = 0u;
    for (uint k = 0u; k < count; k++)
    {
        uvec2 other = pairs[k];
        bool isLess = other.y != pair.y ? other.y < pair.y : other.x != pair.x ? other.x < pair.x : k < i;
        rank += isLess ? 1u : 0u;
    }
    return rank;
}

void orderBucket(uint bucket, uint k)
{
    uint count = countOf(bucket), sum = 0u;
    if (k == 0u)
        before = counters[unorderedCounter];
    for (uint i = k; i < count; i += LOCAL_SIZE)
        pairs[i] = inBuckets[bucket * BUCKET_SIZE + i];
    barrier();
    for (uint i = k; i < bucket; i += LOCAL_SIZE)
        sum += countOf(i);
    if (sum != 0u)
        atomicAdd(before, sum);
    barrier();
    for (uint i = k; i < count; i += LOCAL_SIZE)
        inOrder[rankOf(i, count)] = pairs[i];
    barrier();
    // Neighbouring invocations write next to each other: the results lie in the processor's memory.
    for (uint i = k; i < count; i += LOCAL_SIZE)
        outResults[resultsAt + min(before + i, survivorCapacity)] = inOrder[i];
}

void main()
{
    uint k = gl_LocalInvocationID.x;
    if (GROUP < bucketCount)
        orderBucket(GROUP, k);
    finish(gl_NumWorkGroups.x * gl_NumWorkGroups.y, k, nodesRan | nodePairsRan | trianglePairsRan | pairTestsRan);
}
